// The little JSON that the program writes and reads back: one object of strings, numbers and lists of them.
#pragma once

#include <map>
#include <string>

namespace noiseloom {

// The text in quotes, escaped.
std::string json_string(const std::string& text);
// A number with the shortest digits that read back to the same double; JSON has no inf or nan: those become null.
std::string json_number(double value);

// The members of the outermost object: strings unescaped, anything else as its source text. Throws UserError with
// `name` when the text is not such an object.
std::map<std::string, std::string> parse_json_object(const std::string& text, const std::string& name);

}  // namespace noiseloom
