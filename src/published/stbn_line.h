// What the command lines of ScalarApp and VectorApp have in common, the programs of the spatiotemporal blue noise SDK
// [STBN22].
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "noiseloom/published/line.h"
#include "published/words.h"

namespace noiseloom {

inline constexpr std::int64_t published_seed = 0x1337FEED;  // of both programs, which take no other
inline constexpr std::int64_t most_size = 1 << 20;
inline constexpr Bounds sigma_bounds = {0.001, 65536};

// An option of a program, and the words after it. Options are "-x 5", "--dimsX 5" or "--dimsX=5".
class OptionLine {
 public:
  // Puts what stands behind "=" into a word of its own.
  explicit OptionLine(const std::vector<std::string>& given) : words_(split(given)), reader_(words_) {}

  // Calls `take(name, reader)` for each option, by its long name; it returns false where it does not know it.
  template <class Take>
  void read(const std::vector<std::pair<std::string, std::string>>& letters, const std::vector<std::string>& known,
            PublishedExtras& extras, Take take) {
    while (!reader_.at_end()) {
      if (reader_.take_extra(extras)) continue;
      std::string name = reader_.peek();
      for (const auto& [letter, longer] : letters)
        if (name == letter) name = longer;
      if (!take(name, reader_)) reader_.unknown_option(known);
    }
  }
  WordReader& reader() { return reader_; }

 private:
  static std::vector<std::string> split(const std::vector<std::string>& given) {
    std::vector<std::string> words;
    for (const std::string& word : given) {
      const std::size_t equals = word.find('=');
      if (word.starts_with("--") && equals != std::string::npos) {
        words.push_back(word.substr(0, equals));
        words.push_back(word.substr(equals + 1));
      } else {
        words.push_back(word);
      }
    }
    return words;
  }

  std::vector<std::string> words_;
  WordReader reader_;
};

inline bool asks_for_help(const std::vector<std::string>& words) {
  for (const std::string& word : words)
    if (word == "--help" || word == "-h") return true;
  return false;
}

inline void read_size(WordReader& reader, const std::string& name, std::int64_t& size) {
  reader.skip();
  size = reader.integer(name, 1, most_size).value_or(size);
}
inline void read_sigma(WordReader& reader, const std::string& name, double& sigma) {
  reader.skip();
  sigma = reader.number(name, sigma_bounds).value_or(sigma);
}
inline void read_folder(WordReader& reader, std::string& folder) {
  reader.skip();
  folder = reader.text("--output DIR");
  if (folder.empty()) reader.fault("the name of the folder is empty");
}

// PNGs of one slice each, DIR/NAME_{slice}.png.
inline void name_images(PublishedLine& line, const std::string& folder, const std::string& name) {
  const std::string stem = (std::filesystem::path(folder) / name).string();
  line.images.format = "png";
  line.images.layout = "slices";
  line.images.output = stem + "_{slice}.png";
  line.images.overwrite = line.extras.overwrite;
  line.stem = stem;
  line.seed = published_seed;
}

}  // namespace noiseloom
