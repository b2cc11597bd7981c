#include "published/words.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>

#include "noiseloom/core/text.h"

namespace noiseloom {
namespace {

constexpr std::int64_t most_threads_of_a_line = 1024;

template <class Number>
std::optional<Number> whole_number(const std::string& text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

bool same_word(const std::string& a, const std::string& b) {
  const auto low = [](char c) { return std::tolower(static_cast<unsigned char>(c)); };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [&](char x, char y) { return low(x) == low(y); });
}

std::string WordReader::place(std::size_t index) const {
  return index < words_.size() ? fmt::format("word {} \"{}\"", index + 1, words_[index]) : "the end of the line";
}

void WordReader::fault(const std::string& text) {
  faults_.push_back({"command line", fmt::format("{}: {}", place(next_ == 0 ? 0 : next_ - 1), text)});
}

void WordReader::missing(const std::string& what) {
  if (is_short_) return;
  is_short_ = true;
  faults_.push_back({"command line", fmt::format("the line ends where {} must stand", what)});
}

std::string WordReader::text(const std::string& what) {
  if (at_end()) {
    missing(what);
    return "";
  }
  return words_[next_++];
}

std::string WordReader::word(const std::string& what, const std::vector<std::string>& accepted) {
  if (at_end()) {
    missing(fmt::format("{} ({})", what, fmt::join(accepted, ", ")));
    return "";
  }
  const std::string& found = words_[next_++];
  for (const std::string& one : accepted)
    if (same_word(found, one)) return one;
  const std::string near = nearest_word(found, accepted);
  fault(fmt::format("unknown {}; {}accepted: {}", what, near.empty() ? "" : fmt::format("did you mean {}? ", near),
                    fmt::join(accepted, ", ")));
  return "";
}

std::optional<double> WordReader::number(const std::string& what, Bounds bounds) {
  if (at_end()) {
    missing(what);
    return std::nullopt;
  }
  const std::optional<double> value = whole_number<double>(words_[next_++]);
  if (!value || !std::isfinite(*value)) {
    fault(fmt::format("{} must be a number", what));
    return std::nullopt;
  }
  if (*value < bounds.least || *value > bounds.most) {
    fault(fmt::format("{} must be from {} to {}", what, bounds.least, bounds.most));
    return std::nullopt;
  }
  return value;
}

std::optional<std::int64_t> WordReader::integer(const std::string& what, std::int64_t least, std::int64_t most) {
  if (at_end()) {
    missing(what);
    return std::nullopt;
  }
  const std::optional<std::int64_t> value = whole_number<std::int64_t>(words_[next_++]);
  if (!value || *value < least || *value > most) {
    fault(fmt::format("{} must be an integer from {} to {}", what, least, most));
    return std::nullopt;
  }
  return value;
}

void WordReader::unknown_option(const std::vector<std::string>& known) {
  std::vector<std::string> all = known;
  all.insert(all.end(), extra_options().begin(), extra_options().end());
  const std::string near = nearest_word(peek(), all);
  skip();
  fault(fmt::format("unknown option; {}accepted: {}", near.empty() ? "" : fmt::format("did you mean {}? ", near),
                    fmt::join(all, ", ")));
  if (!at_end() && !peek().starts_with("-")) skip();  // its value, as it seems
}

void WordReader::fault_of_line(const std::string& text) { faults_.push_back({"command line", text}); }

const std::vector<std::string>& WordReader::extra_options() {
  static const std::vector<std::string> options = {"--print-config", "--threads",   "--progress", "--quiet",
                                                   "--json",         "--overwrite", "--help"};
  return options;
}

bool WordReader::take_extra(PublishedExtras& extras) {
  const std::string option = peek();
  bool* flag = nullptr;
  if (option == "--print-config") flag = &extras.print_config;
  if (option == "--overwrite") flag = &extras.overwrite;
  if (option == "--quiet") flag = &extras.quiet;
  if (option == "--json") flag = &extras.json;
  if (option == "--help" || option == "-h") flag = &extras.help;
  if (flag != nullptr) {
    *flag = true;
    skip();
    return true;
  }
  if (option == "--threads") {
    skip();
    if (const auto threads = integer("the number of threads", 1, most_threads_of_a_line))
      extras.threads = static_cast<int>(*threads);
    return true;
  }
  if (option == "--progress") {
    skip();
    if (const std::string word_found = word("kind of progress", {"auto", "plain", "json", "none"}); !word_found.empty())
      extras.progress = word_found;
    return true;
  }
  return false;
}

std::string extras_help() {
  return "  --print-config     print the config that the line means, and make nothing\n"
         "  --threads N        threads; all processors if not given\n"
         "  --progress WORD    auto, plain, json or none (none: the result and warnings alone are printed)\n"
         "  --quiet            print nothing but warnings and errors, not even the result\n"
         "  --json             the result as one JSON object\n"
         "  --overwrite        replace files that exist\n"
         "  -h,--help          this text\n";
}

}  // namespace noiseloom
