// The grammar of the program that comes with [FAST24].
#include <fmt/format.h>

#include <array>
#include <bit>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>

#include "noiseloom/core/json.h"
#include "noiseloom/core/text.h"
#include "noiseloom/image/naming.h"
#include "noiseloom/image/sequence.h"
#include "published/programs.h"
#include "published/words.h"

namespace noiseloom {
namespace {

const std::vector<std::string> own_options = {"-split", "-numsteps", "-output", "-seed", "-init", "-progress"};

constexpr std::int64_t most_pixels_a_side = 1 << 20;
constexpr std::int64_t most_steps = 1'000'000'000;
constexpr std::int64_t numbers_of_a_texel = 4;

struct SpaceWords {
  std::string space;
  std::string distribution;
  std::string samples;   // here
  std::string distance;  // of a list of such samples
  int channels = 1;
  const char* range = "0:1";  // that 0 and 1 of an image stand for
};

const std::vector<SpaceWords>& space_words() {
  static const std::vector<SpaceWords> rows = {
      {"Real", "Uniform", "uniform", "absolute"},
      {"Real", "Tent", "tent", "absolute"},
      // 0.5 + 0.15 x
      {"Real", "Gauss", "gauss", "absolute", 1, "-3.3333333333333335:3.3333333333333335"},
      {"Circle", "Uniform", "circle", "circle"},
      {"Vector2", "Uniform", "vector2", "euclidean", 2},
      {"Vector3", "Uniform", "vector3", "euclidean", 3},
      {"Vector4", "Uniform", "vector4", "euclidean", 4},
      {"Sphere", "Uniform", "sphere", "angle", 3, "-1:1"},
      {"Sphere", "Cosine", "hemisphere-cosine", "angle", 3, "-1:1"},
      {"Sphere", "UniformHemisphere", "hemisphere", "angle", 3, "-1:1"},
  };
  return rows;
}

// What stands on the line, as far as it could be read.
struct FastLine {
  SpaceWords space;
  std::string xy;  // of a group, without axes: kernel = "box", size = 3
  std::string z;
  double weight = -1;  // of space; negative: product
  std::array<std::int64_t, 3> size = {1, 1, 1};
  std::string file;
  bool split = false;
  std::int64_t steps = 10'000;
  std::string output = "png";
  std::int64_t seed = -1;
  std::string init;
  std::int64_t pictures = 0;
};

SpaceWords read_space(WordReader& words) {
  std::vector<std::string> spaces;
  for (const SpaceWords& row : space_words())
    if (spaces.empty() || spaces.back() != row.space) spaces.push_back(row.space);
  const std::string space = words.word("SPACE", spaces);
  std::vector<std::string> distributions;
  for (const SpaceWords& row : space_words())
    if (row.space == space || space.empty()) distributions.push_back(row.distribution);
  const std::string distribution = words.word("DIST" + (space.empty() ? "" : " of " + space), distributions);
  for (const SpaceWords& row : space_words())
    if (row.space == space && row.distribution == distribution) return row;
  return {};
}

std::string read_filter(WordReader& words, const std::string& what, bool over_time) {
  std::vector<std::string> accepted = {"Box", "Gauss", "Binomial"};
  if (over_time) accepted.emplace_back("Exponential");
  const std::string filter = words.word(what, accepted);
  if (filter.empty()) {
    if (!words.at_end()) words.skip();  // its parameter
    return "";
  }
  if (filter == "Box")
    return fmt::format("kernel = \"box\", size = {}", words.integer(what + " Box SIZE", 1, 65536).value_or(1));
  if (filter == "Binomial")
    return fmt::format("kernel = \"binomial\", n = {}", words.integer(what + " Binomial N", 1, 1000).value_or(1));
  if (filter == "Gauss")
    return fmt::format("kernel = \"gauss\", sigma = {}",
                       number_text(words.number(what + " Gauss SIGMA", {0.001, 65536}).value_or(1)));
  const double alpha = words.number("Z Exponential ALPHA", {std::numeric_limits<double>::min(), 1}).value_or(1);
  const double beta = words.number("Z Exponential BETA", {0, 1}).value_or(0);
  return fmt::format("kernel = \"ema\", alpha = {}, rejection = {}", number_text(alpha), number_text(beta));
}

// A name becomes a pattern of files, and folders are made for it: nothing in it may be taken for a place of a number.
std::string read_file_name(WordReader& words) {
  std::string name = words.text("FILE");
  for (char& c : name)
    if (c == '%') c = '_';
  if (name.empty()) return name;
  if (is_sequence_pattern(name) || !why_no_file_name(name).empty())
    words.fault(
        "FILE must hold no sign for a number or for any text, as {}, ### and * are; -split puts numbers behind it");
  if (name.ends_with("/") || std::filesystem::is_directory(name)) words.fault("FILE is a folder; must be a name in it");
  return name;
}

void read_option(WordReader& words, FastLine& line) {
  const std::string option = words.peek();
  if (same_word(option, "-split")) {
    words.skip();
    line.split = true;
  } else if (same_word(option, "-numsteps")) {
    words.skip();
    line.steps = words.integer("-numsteps N", 1, most_steps).value_or(line.steps);
  } else if (same_word(option, "-output")) {
    words.skip();
    line.output = words.word("-output", {"exr", "csv"});
  } else if (same_word(option, "-seed")) {
    words.skip();
    line.seed = words.integer("-seed U32", 0, std::numeric_limits<std::uint32_t>::max()).value_or(0);
  } else if (same_word(option, "-init")) {
    words.skip();
    line.init = words.text("-init FILE");
  } else if (same_word(option, "-progress")) {
    words.skip();
    line.pictures = words.integer("-progress COUNT", 1, 100'000).value_or(0);
  } else {
    words.unknown_option(own_options);
  }
}

FastLine read_words(WordReader& words, PublishedExtras& extras) {
  FastLine line;
  while (!words.at_end() && words.take_extra(extras)) {
  }
  line.space = read_space(words);
  line.xy = read_filter(words, "XY", false);
  line.z = read_filter(words, "Z", true);
  if (words.word("COMBINE", {"Separate", "Product"}) == "Separate")
    line.weight = words.number("COMBINE Separate WEIGHT", {0, 1}).value_or(0.5);
  for (std::size_t axis = 0; axis < 3; ++axis)
    line.size[axis] = words.integer(std::string(1, "WHD"[axis]), 1, most_pixels_a_side).value_or(1);
  line.file = read_file_name(words);
  while (!words.at_end())
    if (!words.take_extra(extras)) read_option(words, line);
  if (line.pictures > line.steps)
    words.fault_of_line(fmt::format("-progress {}: more pictures than the {} steps", line.pictures, line.steps));
  return line;
}

std::string groups_of(const FastLine& line) {
  std::string weights[2];
  if (line.weight >= 0 && line.size[2] > 1) {
    weights[0] = fmt::format(", weight = {}", number_text(line.weight));
    weights[1] = fmt::format(", weight = {}", number_text(1 - line.weight));
  }
  const std::string xy = fmt::format("{{ axes = \"xy\", {}{} }}", line.xy, line.weight == 1 ? "" : weights[0]);
  const std::string t = fmt::format("{{ axes = \"t\", {}{} }}", line.z, line.weight == 0 ? "" : weights[1]);
  if (line.size[2] == 1 || line.weight == 1) return xy;
  return line.weight == 0 ? t : xy + ",\n            " + t;
}

// The numbers of -init, of which a sample takes the first.
PublishedInput read_init(const FastLine& line) {
  const auto& [width, height, depth] = line.size;
  const std::int64_t texels = width * height * depth;
  const std::int64_t expected = texels * numbers_of_a_texel * static_cast<std::int64_t>(sizeof(float));
  std::error_code error;
  const auto found = std::filesystem::file_size(line.init, error);
  if (error) throw UserError(line.init, "cannot be read: " + error.message());
  if (std::cmp_not_equal(found, expected))
    throw UserError(line.init, fmt::format("{} bytes; -init takes 4 floats for each of {}x{}x{} texels: {} bytes",
                                           found, width, height, depth, expected));
  static_assert(std::endian::native == std::endian::little);
  std::vector<float> texel_numbers(static_cast<std::size_t>(texels * numbers_of_a_texel));
  std::ifstream stream(line.init, std::ios::binary);
  stream.read(reinterpret_cast<char*>(texel_numbers.data()), expected);
  if (!stream) throw EnvironmentError(line.init + ": cannot be read");
  const auto channels = static_cast<std::size_t>(line.space.channels);
  PublishedInput input{line.file + ".unfinished.npy", {}, {}};
  if (depth > 1) input.shape.push_back(depth);
  input.shape.insert(input.shape.end(), {height, width, line.space.channels});
  std::vector<float> values;
  for (std::size_t texel = 0; texel < texel_numbers.size(); texel += numbers_of_a_texel)
    values.insert(values.end(), texel_numbers.begin() + static_cast<std::ptrdiff_t>(texel),
                  texel_numbers.begin() + static_cast<std::ptrdiff_t>(texel + channels));
  input.values = [taken = std::move(values)] { return taken; };
  return input;
}

std::string config_text(const FastLine& line, std::int64_t seed) {
  const std::string depth = line.size[2] > 1 ? fmt::format(", t = {}", line.size[2]) : "";
  const std::string list = json_string(std::filesystem::path(line.file + ".unfinished.npy").filename().string());
  std::string text = fmt::format("[texture]\nsize    = {{ x = {}, y = {}{} }}\n", line.size[0], line.size[1], depth);
  text += line.init.empty() ? fmt::format("samples = \"{}\"\n", line.space.samples)
                            : fmt::format("samples = {{ file = {}, distance = \"{}\" }}\n", list, line.space.distance);
  text += fmt::format("seed    = {}\n\n[filter]\ncombine = \"{}\"\ngroups  = [ {} ]\n\n[optimizer]\n", seed,
                      line.weight >= 0 ? "sum" : "product", groups_of(line));
  if (!line.init.empty()) text += fmt::format("start   = {{ file = {} }}\n", list);
  return text + fmt::format("stop    = {{ iterations = {} }}\n", line.steps);
}

ExportOptions images_of(const FastLine& line) {
  ExportOptions images;
  const bool is_gauss = line.space.samples == "gauss";
  images.format = line.output == "png" && is_gauss ? "hdr" : line.output;
  const bool is_split = line.split && line.size[2] > 1;
  images.output = fmt::format("{}{}.{}", line.file, is_split ? "_{slice}" : "", images.format);
  images.layout = is_split ? "slices" : "strip";
  if (images.format == "png" || images.format == "exr") images.channels = "RGBA";
  if (images.format != "exr" && (is_gauss || !line.init.empty())) images.range = line.space.range;
  return images;
}

std::vector<std::string> notes_of(const FastLine& line) {
  std::vector<std::string> notes;
  if (line.z.ends_with("rejection = 0.0"))
    notes.emplace_back(
        "Exponential with BETA 0 is an average that never loses its history; the published program cuts it off after 1 "
        "to D frames, all alike");
  if (!line.init.empty())
    notes.push_back(fmt::format("the config names the numbers of {} as .npy: {}, which is there while images are made",
                                line.init, line.file + ".unfinished.npy"));
  return notes;
}

}  // namespace

PublishedLine read_fastnoise(const std::vector<std::string>& given) {
  PublishedLine result;
  for (const std::string& word : given) result.extras.help = result.extras.help || word == "--help" || word == "-h";
  if (result.extras.help) return result;
  WordReader words(given);
  const FastLine line = read_words(words, result.extras);
  words.throw_faults();
  if (!line.init.empty()) result.inputs.push_back(read_init(line));
  result.seed_is_drawn = line.seed < 0;
  result.seed = result.seed_is_drawn ? std::random_device{}() : line.seed;
  result.config = config_text(line, result.seed);
  result.notes = notes_of(line);
  result.images = images_of(line);
  result.images.overwrite = result.extras.overwrite;
  result.stem = line.file;
  result.slices = line.size[2];
  for (std::int64_t picture = 1; picture <= line.pictures; ++picture)
    result.steps.push_back(line.steps * picture / line.pictures);
  return result;
}

std::string fastnoise_help() {
  return "Command lines of the program that comes with filter-adapted sampling, as they are.\n"
         "Usage: noiseloom fastnoise SPACE DIST XY Z COMBINE W H D FILE [OPTIONS]\n\n"
         "  SPACE    Real, Circle, Vector2, Vector3, Vector4, Sphere (upper and lower case are one, here and below)\n"
         "  DIST     Uniform; of Real also Tent, Gauss; of Sphere also Cosine, UniformHemisphere\n"
         "  XY       Box SIZE, Gauss SIGMA or Binomial N: the filter over space\n"
         "  Z        the same, or Exponential ALPHA BETA: over time\n"
         "  COMBINE  Product, or Separate WEIGHT: of space, 1 - WEIGHT of time\n"
         "  W H D    width, height and slices: any sizes\n"
         "  FILE     name of the image without its ending; % becomes _\n\n"
         "Options:\n"
         "  -split             an image a slice, FILE_0.png, instead of all under each other\n"
         "  -numsteps N        iterations (10000)\n"
         "  -output KIND       exr or csv: float numbers; else png, or hdr (0.5 + 0.15 x) for Gauss\n"
         "  -seed U32          without it a seed is drawn, and told\n"
         "  -init FILE         the texture to begin with: 4 floats a texel, x fastest, then y, then slices\n"
         "  -progress COUNT    also so many textures of fewer iterations, FILE.STEP.png, each made by itself\n" +
         extras_help() +
         "\nImages are 8-bit RGBA: a scalar stands in R, G and B; directions are 0.5 + 0.5 v. Filters that are wider "
         "than\n"
         "the texture wrap around. Texture and run are as good as generate makes them, not as the published program "
         "does.\n\n"
         "  noiseloom fastnoise real Uniform Gauss 1.0 Exponential 0.1 0.1 Separate 0.5 128 128 32 out/noise -split\n";
}

}  // namespace noiseloom
