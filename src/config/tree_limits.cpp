#include "config/tree_limits.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstddef>

#include "noiseloom/config/tree.h"

namespace noiseloom::settings {
namespace {

using namespace std::string_view_literals;

struct Signature {
  std::string_view bytes;
  std::string_view meaning;
};

constexpr Signature signatures[] = {
    {"noiseloom run file"sv, "a run file"},
    {"\x89HDF\r\n\x1a\n"sv, "an HDF5 file"},
    {"\x89PNG\r\n\x1a\n"sv, "an image (PNG)"},
    {"\x76\x2f\x31\x01"sv, "an image (OpenEXR)"},
    {"II*\0"sv, "an image (TIFF)"},
    {"MM\0*"sv, "an image (TIFF)"},
    {"II+\0"sv, "an image (TIFF)"},
    {"MM\0+"sv, "an image (TIFF)"},
    {"#?RADIANCE"sv, "an image (Radiance HDR)"},
    {"#?RGBE"sv, "an image (Radiance HDR)"},
    {"\xff\xd8\xff"sv, "an image (JPEG)"},
    {"GIF8"sv, "an image (GIF)"},
    {"BM"sv, "an image (BMP)"},
    {"DDS "sv, "an image (DDS)"},
    {"\xabKTX "sv, "an image (KTX)"},
    {"P5\n"sv, "an image (PGM)"},
    {"P6\n"sv, "an image (PPM)"},
    {"Pf\n"sv, "an image (PFM)"},
    {"PF\n"sv, "an image (PFM)"},
    {"\x93NUMPY"sv, "an array (.npy)"},
    {"PK\x03\x04"sv, "a zip archive, such as .npz"},
    {"\x1f\x8b"sv, "a gzip archive"},
    {"%PDF"sv, "a PDF"},
    {"\x7f"
     "ELF"sv,
     "a program"},
    {"\xff\xfe"sv, "text in UTF-16"},
    {"\xfe\xff"sv, "text in UTF-16"},
};

bool is_ascii(char c) { return static_cast<unsigned char>(c) < 0x80; }
bool continues(char c) { return (static_cast<unsigned char>(c) & 0xC0) == 0x80; }

// Bytes of the character that begins the text; 0 if it is none of UTF-8. Surrogates and overlong forms are not sorted
// out: the TOML library refuses them.
std::size_t character_bytes(std::string_view text) {
  const auto first = static_cast<unsigned char>(text.front());
  const std::size_t length = first < 0x80   ? 1
                             : first < 0xC2 ? 0
                             : first < 0xE0 ? 2
                             : first < 0xF0 ? 3
                             : first < 0xF5 ? 4
                                            : 0;
  if (length > text.size()) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if (!continues(text[i])) return 0;
  }
  return length;
}

// Where the text stops to be UTF-8; its size if it does not.
std::size_t bad_byte(std::string_view text) {
  std::size_t at = 0;
  while (at < text.size()) {
    const std::size_t bytes = character_bytes(text.substr(at));
    if (bytes == 0) break;
    at += bytes;
  }
  return at;
}

// Walks through a text, one token at a time.
class Scan {
 public:
  explicit Scan(std::string_view text) : text_(text) {}

  std::optional<LineFault> run() {
    if (text_.starts_with("\xef\xbb\xbf")) at_ = 3;
    while (at_ < text_.size()) {
      step();
      if (fault_ != nullptr) return LineFault{line_, fmt::format("not valid TOML: {}", fault_)};
      if (dots_ >= max_key_parts) {
        return LineFault{line_, fmt::format("a key of more than {} parts; no setting has that many", max_key_parts)};
      }
      if (depth_ > max_nesting) {
        return LineFault{line_, fmt::format("tables and lists more than {} deep; no setting is", max_nesting)};
      }
    }
    return std::nullopt;
  }

 private:
  void step() {
    const char c = text_[at_];
    if (c == '"' || c == '\'') return skip_string(c);
    if (c == '#') return skip_to_newline();
    if (!is_ascii(c)) fault_ = "a character beyond ASCII that is not in quotes";
    ++at_;
    if (c == '\n') ++line_;
    if (c == '[' || c == '{') ++depth_;
    if ((c == ']' || c == '}') && depth_ > 0) --depth_;
    if (c == '.') {
      ++dots_;
    } else if (c == '\n' || c == '=' || c == ',' || c == '[' || c == ']' || c == '{' || c == '}') {
      dots_ = 0;
    }
  }

  void skip_to_newline() {
    while (at_ < text_.size() && text_[at_] != '\n') ++at_;
  }

  // A string over several lines ends at three quotes, any other at the next one, or at the end of its line: there the
  // library finds that it is not closed.
  void skip_string(char quote) {
    const std::string three(3, quote);
    const bool is_long = text_.substr(at_, 3) == three;
    at_ += is_long ? 3 : 1;
    while (at_ < text_.size()) {
      if (is_long && quote == '"' && text_[at_] == '\\') check_line_end();
      if (is_long && text_.substr(at_, 3) == three) break;
      if (!is_long && (text_[at_] == quote || text_[at_] == '\n')) break;
      const bool escaped = quote == '"' && text_[at_] == '\\' && at_ + 1 < text_.size() && text_[at_ + 1] != '\n';
      at_ += escaped ? 1 : 0;
      if (text_[at_] == '\n') ++line_;
      ++at_;
    }
    if (at_ >= text_.size() || text_[at_] == '\n') return;
    at_ += is_long ? 3 : 1;
    while (is_long && at_ < text_.size() && text_[at_] == quote) ++at_;  // """" ends with a quote of its own
  }

  // What follows the blanks behind a backslash.
  void check_line_end() {
    const std::size_t next = text_.find_first_not_of(" \t\r\n", at_ + 1);
    if (next != std::string_view::npos && !is_ascii(text_[next])) {
      fault_ = "a character beyond ASCII right after a backslash, or after one that ends a line";
    }
  }

  std::string_view text_;
  const char* fault_ = nullptr;
  std::size_t at_ = 0;
  int line_ = 1;
  std::size_t depth_ = 0;
  std::size_t dots_ = 0;
};

}  // namespace

std::string_view foreign_format(std::string_view beginning) {
  std::string_view text = beginning;
  if (text.starts_with("RIFF") && text.size() >= 12 && text.substr(8, 4) == "WEBP") return "an image (WebP)";
  for (const Signature& signature : signatures) {
    if (text.starts_with(signature.bytes)) return signature.meaning;
  }
  // JSON and XML may begin with blanks.
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.front())) != 0) text.remove_prefix(1);
  if (text.starts_with('{')) return "JSON";
  if (text.starts_with('<')) return "XML or HTML";
  return {};
}

bool is_utf8(std::string_view text) { return bad_byte(text) == text.size(); }

std::optional<LineFault> early_fault(std::string_view text) {
  if (const std::size_t bad = bad_byte(text); bad < text.size()) {
    const auto lines_before = std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(bad), '\n');
    return LineFault{static_cast<int>(lines_before) + 1, "not valid TOML: not text in UTF-8"};
  }
  return Scan(text).run();
}

}  // namespace noiseloom::settings
