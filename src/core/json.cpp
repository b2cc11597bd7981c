#include "noiseloom/core/json.h"

#include <fmt/format.h>

#include <cmath>
#include <cstddef>

#include "noiseloom/core/error.h"

namespace noiseloom {
namespace {

class Scanner {
 public:
  Scanner(const std::string& text, const std::string& name) : text_(text), name_(name) {}

  std::map<std::string, std::string> object() {
    std::map<std::string, std::string> members;
    expect('{');
    if (peek() != '}') {
      do {
        const std::string key = string();
        expect(':');
        members[key] = peek() == '"' ? string() : other();
      } while (accept(','));
    }
    expect('}');
    return members;
  }

 private:
  [[noreturn]] void fail(const std::string& wanted) const {
    throw UserError(name_, fmt::format("not the JSON that was expected: {} at byte {}", wanted, at_));
  }
  char peek() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\n' || text_[at_] == '\t' || text_[at_] == '\r'))
      ++at_;
    return at_ < text_.size() ? text_[at_] : '\0';
  }
  bool accept(char c) {
    if (peek() != c) return false;
    ++at_;
    return true;
  }
  void expect(char c) {
    if (!accept(c)) fail(fmt::format("'{}' is missing", c));
  }
  char take() {
    if (at_ >= text_.size()) fail("the end of a string is missing");
    return text_[at_++];
  }

  std::string string() {
    expect('"');
    std::string value;
    for (char c = take(); c != '"'; c = take()) value += c == '\\' ? escape() : c;
    return value;
  }
  char escape() {
    const char c = take();
    switch (c) {
      case 'n':
        return '\n';
      case 't':
        return '\t';
      case 'r':
        return '\r';
      case 'u': {  // written here for control characters only
        int code = 0;
        for (int digit = 0; digit < 4; ++digit) {
          const std::size_t value = std::string("0123456789abcdef").find(take());
          if (value == std::string::npos) fail("four hexadecimal digits are missing");
          code = code * 16 + static_cast<int>(value);
        }
        if (code >= 128) fail("an escaped character outside ASCII");
        return static_cast<char>(code);
      }
      default:
        return c;
    }
  }
  std::string other() {
    const std::size_t begin = at_;
    int depth = 0;
    for (;; ++at_) {
      if (at_ >= text_.size()) fail("the end of a value is missing");
      const char c = text_[at_];
      if (depth == 0 && (c == ',' || c == '}')) break;
      depth += c == '[' ? 1 : c == ']' ? -1 : 0;
    }
    const std::size_t end = text_.find_last_not_of(" \n\t\r", at_ - 1) + 1;
    return text_.substr(begin, end - begin);
  }

  const std::string& text_;
  const std::string& name_;
  std::size_t at_ = 0;
};

}  // namespace

std::string json_string(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (c == '\n') {
      quoted += "\\n";
    } else if (static_cast<unsigned char>(c) < 0x20) {
      quoted += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

std::string json_number(double value) { return std::isfinite(value) ? fmt::format("{}", value) : "null"; }

std::string json_object(const std::vector<JsonMember>& members) {
  std::string text;
  for (const auto& [name, value] : members) {
    text += text.empty() ? "{" : ", ";
    text += json_string(name) + ": ";
    if (const auto* number = std::get_if<double>(&value)) {
      text += json_number(*number);
    } else if (const auto* count = std::get_if<std::int64_t>(&value)) {
      text += std::to_string(*count);
    } else {
      text += json_string(std::get<std::string>(value));
    }
  }
  return (text.empty() ? "{" : text) + "}";
}

std::map<std::string, std::string> parse_json_object(const std::string& text, const std::string& name) {
  return Scanner(text, name).object();
}

}  // namespace noiseloom
