// The little JSON that the program writes and reads back: one object of strings, numbers and lists of them.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace noiseloom {

// The text in quotes, escaped.
std::string json_string(const std::string& text);
// A number with the shortest digits that read back to the same double; JSON has no inf or nan: those become null.
std::string json_number(double value);

// An object of these members, in their order, on one line.
using JsonMember = std::pair<std::string, std::variant<std::int64_t, double, std::string>>;
std::string json_object(const std::vector<JsonMember>& members);

// The members of the outermost object: strings unescaped, anything else as its source text. Throws UserError with
// `name` when the text is not such an object.
std::map<std::string, std::string> parse_json_object(const std::string& text, const std::string& name);

}  // namespace noiseloom
