// The grammars of ScalarApp and VectorApp, the programs of the spatiotemporal blue noise SDK [STBN22].
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>

#include "noiseloom/core/json.h"
#include "noiseloom/core/math.h"
#include "noiseloom/core/text.h"
#include "noiseloom/image/naming.h"
#include "noiseloom/image/sequence.h"
#include "published/programs.h"
#include "published/words.h"

namespace noiseloom {
namespace {

constexpr std::int64_t published_seed = 0x1337FEED;  // of both programs, which take no other
constexpr std::int64_t most_size = 1 << 20;
constexpr Bounds sigma_bounds = {0.001, 65536};

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

bool asks_for_help(const std::vector<std::string>& words) {
  for (const std::string& word : words)
    if (word == "--help" || word == "-h") return true;
  return false;
}

void read_size(WordReader& reader, const std::string& name, std::int64_t& size) {
  reader.skip();
  size = reader.integer(name, 1, most_size).value_or(size);
}
void read_sigma(WordReader& reader, const std::string& name, double& sigma) {
  reader.skip();
  sigma = reader.number(name, sigma_bounds).value_or(sigma);
}
void read_folder(WordReader& reader, std::string& folder) {
  reader.skip();
  folder = reader.text("--output DIR");
  if (folder.empty()) reader.fault("the name of the folder is empty");
}

// PNGs of one slice each, DIR/NAME_{slice}.png.
void name_images(PublishedLine& line, const std::string& folder, const std::string& name) {
  const std::string stem = (std::filesystem::path(folder) / name).string();
  line.images.format = "png";
  line.images.layout = "slices";
  line.images.output = stem + "_{slice}.png";
  line.images.overwrite = line.extras.overwrite;
  line.stem = stem;
  line.seed = published_seed;
}

struct ScalarLine {
  std::string folder = "output";
  std::array<std::int64_t, 4> size = {128, 128, 64, 1};
  std::array<double, 4> sigma = {1.9, 1.9, 1.9, 1.9};
  double density = 0.1;
  std::string implementation = "sc211";
};

const std::vector<std::string> scalar_options = {
    "-o",   "--output", "--dimsX", "--dimsY", "--dimsZ", "--dimsW",         "--sX",
    "--sY", "--sZ",     "--sW",    "--ibpd",  "-i",      "--implementation"};

bool read_scalar_option(const std::string& name, WordReader& reader, ScalarLine& line) {
  constexpr std::string_view axes = "XYZW";
  for (std::size_t axis = 0; axis < axes.size(); ++axis) {
    if (name == fmt::format("--dims{}", axes[axis])) return read_size(reader, name, line.size[axis]), true;
    if (name == fmt::format("--s{}", axes[axis])) return read_sigma(reader, name, line.sigma[axis]), true;
  }
  if (name == "--output") return read_folder(reader, line.folder), true;
  if (name == "--ibpd") {
    reader.skip();
    line.density = reader.number(name, {0, 0.5}).value_or(line.density);
    return true;
  }
  if (name != "--implementation") return false;
  reader.skip();
  line.implementation = reader.word(name, {"sc211", "sc22", "r211", "r22"});
  return true;
}

// Axes of one group share a sigma: x and y always, z and w in 2D x 2D.
void check_sigmas(WordReader& reader, const ScalarLine& line, bool pairs) {
  if (line.sigma[0] != line.sigma[1])
    reader.fault_of_line(
        fmt::format("--sX {} and --sY {}: must be the same, as x and y have one kernel", line.sigma[0], line.sigma[1]));
  if (pairs && line.size[2] > 1 && line.size[3] > 1 && line.sigma[2] != line.sigma[3])
    reader.fault_of_line(fmt::format("--sZ {} and --sW {}: must be the same, as z and w have one kernel in {}",
                                     line.sigma[2], line.sigma[3], line.implementation));
}

std::string mask_groups(const ScalarLine& line, bool pairs) {
  const auto group = [](const std::string& axes, double sigma) {
    return fmt::format("\n  {{ axes = \"{}\", kernel = \"gauss-energy\", sigma = {} }},", axes, number_text(sigma));
  };
  const bool has_z = line.size[2] > 1;
  const bool has_w = line.size[3] > 1;
  std::string text = group("xy", line.sigma[0]);
  if (pairs && has_z && has_w) return text + group("zw", line.sigma[2]);
  if (has_z) text += group("z", line.sigma[2]);
  if (has_w) text += group("w", line.sigma[3]);
  return text;
}

std::string mask_config(const ScalarLine& line, bool pairs) {
  std::string size = fmt::format("x = {}, y = {}", line.size[0], line.size[1]);
  if (line.size[2] > 1) size += fmt::format(", z = {}", line.size[2]);
  if (line.size[3] > 1) size += fmt::format(", w = {}", line.size[3]);
  return fmt::format(
      "[texture]\nsize    = {{ {} }}\nsamples = \"uniform\"\nseed    = {}\n\n[filter]\ncombine = \"sum\"\n"
      "groups  = [{}\n]\n\n[optimizer]\nmethod  = \"void-and-cluster\"\ndensity = {}\n",
      size, published_seed, mask_groups(line, pairs), number_text(line.density));
}

struct VectorLine {
  std::string folder = "out";
  std::array<std::int64_t, 3> size = {128, 128, 64};
  double energy_sigma = 1.9;
  double value_sigma = 1;
  double swap_count_factor = 0.001;
  double cooling_factor = 0.00001;
  std::string type = "Float2";
  std::string generator = "Uniform";
  std::string distance;
};

const std::vector<std::string> vector_options = {"-o",
                                                 "--output",
                                                 "-x",
                                                 "--dimsX",
                                                 "-y",
                                                 "--dimsY",
                                                 "-z",
                                                 "--dimsZ",
                                                 "--energySigma",
                                                 "--valueSigma",
                                                 "--swapCountFactor",
                                                 "--coolingFactor",
                                                 "-t",
                                                 "--type",
                                                 "-g",
                                                 "--generator",
                                                 "-d",
                                                 "--valueDistance"};

bool read_vector_option(const std::string& name, WordReader& reader, VectorLine& line) {
  constexpr std::string_view axes = "XYZ";
  constexpr Bounds factor_bounds = {std::numeric_limits<double>::min(), 1};
  for (std::size_t axis = 0; axis < axes.size(); ++axis)
    if (name == fmt::format("--dims{}", axes[axis])) return read_size(reader, name, line.size[axis]), true;
  if (name == "--output") return read_folder(reader, line.folder), true;
  if (name == "--energySigma") return read_sigma(reader, name, line.energy_sigma), true;
  if (name == "--valueSigma") return read_sigma(reader, name, line.value_sigma), true;
  const auto choose = [&](std::string& chosen, const std::vector<std::string>& accepted) {
    reader.skip();
    chosen = reader.word(name, accepted);
    return true;
  };
  if (name == "--type") return choose(line.type, {"Float", "Float2", "Float3"});
  if (name == "--generator") return choose(line.generator, {"Uniform", "Unit"});
  if (name == "--valueDistance") return choose(line.distance, {"L1", "L2", "LInfinity", "NegativeDot", "Abs"});
  double* const factor = name == "--swapCountFactor" ? &line.swap_count_factor
                         : name == "--coolingFactor" ? &line.cooling_factor
                                                     : nullptr;
  if (factor == nullptr) return false;
  reader.skip();
  *factor = reader.number(name, factor_bounds).value_or(*factor);
  return true;
}

void check_vector_words(WordReader& reader, const VectorLine& line) {
  const bool is_float = line.type == "Float";
  const std::string& distance = line.distance;
  if (is_float && !distance.empty() && distance != "Abs")
    reader.fault_of_line(fmt::format("--valueDistance {}: Float is compared by Abs", distance));
  if (!is_float && distance == "Abs") reader.fault_of_line("--valueDistance Abs: is for Float alone");
  if (distance == "NegativeDot" && (line.type != "Float3"))
    reader.fault_of_line(fmt::format("--valueDistance NegativeDot: is for Float3, not {}", line.type));
  if (is_float && line.generator == "Unit")
    reader.fault_of_line("--generator Unit: is for Float2 and Float3; a number of length 1 has no direction to vary");
}

// Unit vectors of the plane, one in the middle of each of as many equal arcs as a slice has pixels.
PublishedInput unit_vectors(const VectorLine& line, const std::string& stem) {
  const std::int64_t count = line.size[0] * line.size[1];
  const auto values = [count] {
    std::vector<float> vectors;
    vectors.reserve(static_cast<std::size_t>(2 * count));
    for (std::int64_t i = 0; i < count; ++i) {
      const double turns = (static_cast<double>(i) + 0.5) / static_cast<double>(count);
      vectors.push_back(static_cast<float>(math::cos_2pi(turns)));
      vectors.push_back(static_cast<float>(math::sin_2pi(turns)));
    }
    return vectors;
  };
  return {stem + ".unfinished.npy", {count, 2}, values};
}

// swapCountFactor N^2 swaps of N pixels; an iteration is N / 2 of them.
std::int64_t iterations_of(const VectorLine& line) {
  const double pixels = static_cast<double>(line.size[0] * line.size[1] * line.size[2]);
  return std::max<std::int64_t>(1, std::llround(std::min(2 * line.swap_count_factor * pixels, 1e9)));
}

std::string samples_of(const VectorLine& line, const std::string& stem) {
  if (line.type == "Float") return "\"uniform\"";
  if (line.generator == "Uniform") return line.type == "Float2" ? "\"vector2\"" : "\"vector3\"";
  if (line.type == "Float3") return "\"sphere\"";
  return fmt::format("{{ file = {}, distance = \"angle\" }}",
                     json_string(std::filesystem::path(stem + ".unfinished.npy").filename().string()));
}

std::string vector_config(const VectorLine& line, const std::string& stem) {
  // exp(-r^2 / sigma^2) there is exp(-r^2 / (2 sigma^2)) here.
  const std::string sigma = number_text(line.energy_sigma / std::numbers::sqrt2);
  const std::string depth = line.size[2] > 1 ? fmt::format(", t = {}", line.size[2]) : "";
  const std::string time =
      line.size[2] > 1 ? fmt::format("\n  {{ axes = \"t\", kernel = \"gauss-energy\", sigma = {} }},", sigma) : "";
  return fmt::format(
      "[texture]\nsize    = {{ x = {}, y = {}{} }}\nsamples = {}\nseed    = {}\n\n[filter]\ncombine = \"sum\"\n"
      "groups  = [\n  {{ axes = \"xy\", kernel = \"gauss-energy\", sigma = {} }},{}\n]\n\n[energy]\n"
      "value_kernel = \"stbn\"\nsigma_s      = {}\n\n[optimizer]\nstop    = {{ iterations = {} }}\ncutoff  = 1e-4\n",
      line.size[0], line.size[1], depth, samples_of(line, stem), published_seed, sigma, time,
      number_text(line.value_sigma), iterations_of(line));
}

std::vector<std::string> vector_notes(const VectorLine& line) {
  std::vector<std::string> notes;
  const std::string distance = line.distance.empty() && line.type != "Float" ? "L1" : line.distance;
  const bool by_angle = line.generator == "Unit";
  if (distance == "L1" || distance == "LInfinity" || (distance == "L2" && by_angle) ||
      (distance == "NegativeDot" && !by_angle))
    notes.push_back(fmt::format("--valueDistance {}{}: samples are compared by {} here", distance,
                                line.distance.empty() ? ", the default" : "",
                                by_angle ? "the angle between them" : "their Euclidean distance"));
  if (line.cooling_factor != 0.00001)
    notes.push_back(
        fmt::format("--coolingFactor {}: temperatures are found from the problem here", line.cooling_factor));
  return notes;
}

}  // namespace

PublishedLine read_stbn_scalar(const std::vector<std::string>& words) {
  PublishedLine result;
  result.extras.help = asks_for_help(words);
  if (result.extras.help) return result;
  ScalarLine line;
  OptionLine options(words);
  options.read({{"-o", "--output"}, {"-i", "--implementation"}}, scalar_options, result.extras,
               [&](const std::string& name, WordReader& reader) { return read_scalar_option(name, reader, line); });
  const bool pairs = line.implementation.ends_with("22");
  check_sigmas(options.reader(), line, pairs);
  options.reader().throw_faults();
  name_images(
      result, line.folder,
      fmt::format("stbn_scalar_{}_{}_{}x{}x{}", line.implementation.starts_with("sc") ? "Splice_Cache" : "Reference",
                  pairs ? "2Dx2D" : "2Dx1Dx1D", line.size[0], line.size[1], line.size[2]));
  result.images.channels = "R";
  result.config = mask_config(line, pairs);
  result.slices = line.size[2] * line.size[3];
  return result;
}

PublishedLine read_stbn_vector(const std::vector<std::string>& words) {
  PublishedLine result;
  result.extras.help = asks_for_help(words);
  if (result.extras.help) return result;
  VectorLine line;
  OptionLine options(words);
  options.read({{"-o", "--output"},
                {"-x", "--dimsX"},
                {"-y", "--dimsY"},
                {"-z", "--dimsZ"},
                {"-t", "--type"},
                {"-g", "--generator"},
                {"-d", "--valueDistance"}},
               vector_options, result.extras,
               [&](const std::string& name, WordReader& reader) { return read_vector_option(name, reader, line); });
  check_vector_words(options.reader(), line);
  options.reader().throw_faults();
  const std::string size = fmt::format("{}x{}x{}", line.size[0], line.size[1], line.size[2]);
  name_images(result, line.folder, fmt::format("VectorSTBN_{0}_{0}", size));
  result.images.channels = "RGBA";
  result.config = vector_config(line, result.stem);
  result.notes = vector_notes(line);
  result.slices = line.size[2];
  if (line.type == "Float2" && line.generator == "Unit") {
    result.inputs.push_back(unit_vectors(line, result.stem));
    result.images.range = "-1:1";
  }
  return result;
}

std::string stbn_scalar_help() {
  return "Command lines of ScalarApp, the published maker of scalar spatiotemporal blue noise, as they are.\n"
         "Usage: noiseloom stbn-scalar [OPTIONS]\n\n"
         "Options:\n"
         "  -o,--output DIR    folder to write to (output)\n"
         "  --dimsX N          width (128)\n"
         "  --dimsY N          height (128)\n"
         "  --dimsZ N          slices along z (64)\n"
         "  --dimsW N          slices along w (1)\n"
         "  --sX SIGMA         of the energy along x (1.9), the same as\n"
         "  --sY SIGMA         along y\n"
         "  --sZ SIGMA         along z (1.9)\n"
         "  --sW SIGMA         along w (1.9)\n"
         "  --ibpd SHARE       density of the initial binary pattern (0.1)\n"
         "  -i,--implementation WORD  sc211, r211: xy, z and w each; sc22, r22: xy and zw (sc211)\n" +
         extras_help() +
         "\nWrites DIR/stbn_scalar_Splice_Cache_2Dx1Dx1D_128x128x64_0.png and so on (r211, r22: Reference; sc22, r22: "
         "2Dx2D),\n"
         "8-bit grey; the number is z + Z w. The seed is the one that is built into the published program.\n\n"
         "  noiseloom stbn-scalar --dimsZ 32 -o stbn\n";
}

std::string stbn_vector_help() {
  return "Command lines of VectorApp, the published maker of spatiotemporal blue noise of vectors, as they are.\n"
         "Usage: noiseloom stbn-vector [OPTIONS]\n\n"
         "Options:\n"
         "  -o,--output DIR    folder to write to (out)\n"
         "  -x,--dimsX N       width (128)\n"
         "  -y,--dimsY N       height (128)\n"
         "  -z,--dimsZ N       slices (64)\n"
         "  --energySigma S    of exp(-r^2 / S^2) over pixels and slices (1.9)\n"
         "  --valueSigma S     distance at which samples no longer count as alike (1)\n"
         "  --swapCountFactor F  F N^2 swaps for N pixels are tried (0.001)\n"
         "  --coolingFactor F  taken and noted: temperatures are found from the problem\n"
         "  -t,--type WORD     Float, Float2 or Float3 (Float2)\n"
         "  -g,--generator WORD  Uniform, or Unit: vectors of length 1 (Uniform)\n"
         "  -d,--valueDistance WORD  L1, L2, LInfinity, NegativeDot (Float3), Abs (Float)\n" +
         extras_help() +
         "\nWrites DIR/VectorSTBN_128x128x64_128x128x64_0.png and so on, 8-bit RGBA: 0.5 + 0.5 v. Vectors are compared "
         "by\n"
         "their Euclidean distance, unit vectors by the angle between them; for other words a note says so.\n\n"
         "  noiseloom stbn-vector -t Float3 -g Unit -d NegativeDot -z 32 -o stbn\n";
}

}  // namespace noiseloom
