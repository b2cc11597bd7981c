// The grammar of VectorApp, which makes spatiotemporal blue noise of vectors.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>

#include "noiseloom/core/json.h"
#include "noiseloom/core/math.h"
#include "noiseloom/core/text.h"
#include "published/programs.h"
#include "published/stbn_line.h"

namespace noiseloom {
namespace {

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

std::string value_distance(const VectorLine& line) { return line.distance.empty() ? "L1" : line.distance; }

// NegativeDot of vectors that are not of length 1 is no distance.
bool is_dot_of_points(const VectorLine& line) { return line.distance == "NegativeDot" && line.generator != "Unit"; }

std::string samples_of(const VectorLine& line, const std::string& stem) {
  if (line.type == "Float") return "\"uniform\"";
  const std::string distance = value_distance(line);
  const std::string word = distance == "L1"                                       ? "manhattan"
                           : distance == "LInfinity"                              ? "chebyshev"
                           : distance == "NegativeDot" && !is_dot_of_points(line) ? "cosine"
                                                                                  : "euclidean";
  if (line.generator == "Unit" && line.type == "Float2")
    return fmt::format("{{ file = {}, distance = \"{}\" }}",
                       json_string(std::filesystem::path(stem + ".unfinished.npy").filename().string()), word);
  const std::string space = line.generator == "Unit" ? "sphere" : line.type == "Float2" ? "vector2" : "vector3";
  if (word == "euclidean" && space != "sphere") return fmt::format("\"{}\"", space);
  return fmt::format("{{ space = \"{}\", distance = \"{}\" }}", space, word);
}

// What the published kernel of an axis is divided by: the sum of one half of it, its middle included, up to where it
// falls below 0.005 or has gone half around the axis.
double half_of_kernel(double sigma, std::int64_t size) {
  const auto reach = static_cast<std::int64_t>(sigma * std::sqrt(-2 * math::log(0.005)));
  double sum = 1;
  for (std::int64_t i = 1; i <= std::min(reach, std::max<std::int64_t>(1, size / 2)); ++i) {
    const double x = static_cast<double>(i) / sigma;
    sum += math::exp(-0.5 * x * x);
  }
  return sum;
}

// There, a pair of samples counts exp(-d^(D/3) / (2 S^2)), with d between points of [-1, 1]; here exp(-d^(D/n) / S^2),
// with d between points of [0, 1] or unit vectors.
double value_sigma_of(const VectorLine& line) {
  const double channels = line.type == "Float" ? 1 : line.type == "Float2" ? 2 : 3;
  const double stretched = line.generator == "Unit" ? 1 : math::exp(channels / 3 * math::log(2));
  return line.value_sigma * std::sqrt(2 / stretched);
}

// The texture has an axis t even if it is one slice, as the exponent of the kernel counts three axes.
std::string vector_config(const VectorLine& line, const std::string& stem) {
  const std::string sigma = number_text(line.energy_sigma);
  const auto half = [&line](std::size_t axis) { return half_of_kernel(line.energy_sigma, line.size[axis]); };
  const double plane = half(0) * half(1);
  const auto in_plane = std::clamp<std::int64_t>(std::llround(1e4 * half(2) / (half(2) + plane)), 1, 9999);
  const auto group = [&sigma](const char* axes, std::int64_t weight) {
    return fmt::format("\n  {{ axes = \"{}\", kernel = \"gauss-energy\", sigma = {}, weight = {} }},", axes, sigma,
                       number_text(static_cast<double>(weight) / 1e4));
  };
  const std::string groups =
      line.size[2] > 1 ? group("xy", in_plane) + group("t", 10000 - in_plane) : group("xy", 10000);
  return fmt::format(
      "[texture]\nsize    = {{ x = {}, y = {}, t = {} }}\nsamples = {}\nseed    = {}\n\n[filter]\ncombine = \"sum\"\n"
      "groups  = [{}\n]\n\n[energy]\n"
      "value_kernel = \"stbn\"\nsigma_s      = {}\n\n[optimizer]\nstop    = {{ iterations = {} }}\n",
      line.size[0], line.size[1], line.size[2], samples_of(line, stem), published_seed, groups,
      number_text(value_sigma_of(line)), iterations_of(line));
}

std::vector<std::string> vector_notes(const VectorLine& line) {
  std::vector<std::string> notes;
  if (is_dot_of_points(line))
    notes.push_back(
        "--valueDistance NegativeDot: of vectors that are not of length 1 it is no distance; samples are compared by "
        "their Euclidean distance here");
  if (line.cooling_factor != 0.00001)
    notes.push_back(fmt::format(
        "--coolingFactor {}: there, swaps are taken at random whatever they cost for the first {} N^2, ever more "
        "seldom, which leaves a random arrangement as random as it was; here a swap is taken by what it costs, at "
        "temperatures "
        "that are found from the problem",
        line.cooling_factor, line.cooling_factor));
  return notes;
}

}  // namespace

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

std::string stbn_vector_help() {
  return "Command lines of VectorApp, the published maker of spatiotemporal blue noise of vectors, as they are.\n"
         "Usage: noiseloom stbn-vector [OPTIONS]\n\n"
         "Options:\n"
         "  -o,--output DIR    folder to write to (out)\n"
         "  -x,--dimsX N       width (128)\n"
         "  -y,--dimsY N       height (128)\n"
         "  -z,--dimsZ N       slices (64)\n"
         "  --energySigma S    of exp(-r^2 / 2 S^2) over pixels and slices (1.9)\n"
         "  --valueSigma S     of exp(-d^(D/3) / 2 S^2) between samples of D numbers (1)\n"
         "  --swapCountFactor F  F N^2 swaps for N pixels are tried (0.001)\n"
         "  --coolingFactor F  taken and noted: there, for F N^2 swaps, how often any swap is taken whatever it "
         "costs;\n"
         "                     here swaps are taken by what they cost, at temperatures found from the problem\n"
         "  -t,--type WORD     Float, Float2 or Float3 (Float2)\n"
         "  -g,--generator WORD  Uniform, or Unit: vectors of length 1 (Uniform)\n"
         "  -d,--valueDistance WORD  L1, L2, LInfinity, NegativeDot (Float3), Abs (Float) (L1, Float: Abs)\n" +
         extras_help() +
         "\nWrites DIR/VectorSTBN_128x128x64_128x128x64_0.png and so on, 8-bit RGBA: 0.5 + 0.5 v. NegativeDot of\n"
         "vectors that are not of length 1 is no distance: a note says what is taken in its place.\n\n"
         "  noiseloom stbn-vector -t Float3 -g Unit -d NegativeDot -z 32 -o stbn\n";
}

}  // namespace noiseloom
