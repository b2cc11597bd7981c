// The setting texture.samples: the word of a sample space, or a table that holds it and what goes with it: the
// parameters of the space, or a list of the user's own. Every parameter that a space declares (samples/space.h) is a
// row of the config's table.
#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <deque>
#include <iterator>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "config/run_settings.h"
#include "noiseloom/config/settings_writer.h"
#include "noiseloom/samples/space.h"

namespace noiseloom::settings {
namespace {

constexpr std::string_view key_of_samples = "texture.samples";
constexpr std::string_view key_of_space = "texture.samples.space";
constexpr std::string_view list_of_own = "file";  // the word of SampleSpec::is_file
constexpr std::string_view of_image = "image";    // and of is_image

// In the order of DistanceKind.
constexpr Word distance_table[] = {
    {"absolute", "|a - b| (one channel)", "abs scalar"},
    {"circle", "around a circle of circumference 1 (one channel)", "toroidal wrap"},
    {"euclidean", "length of the difference", "l2 length"},
    {"angle", "angle between unit vectors (two to four channels)", "sphere angular"},
    {"axis", "its sine, where a vector and its opposite are one (three or four channels)", "quaternion rotation line"},
    {"manhattan", "sum of the differences of the channels", "l1 taxicab cityblock"},
    {"chebyshev", "largest difference of a channel", "linf linfinity max maximum"},
    {"cosine", "1 less the cosine of the angle between unit vectors (two to four channels)", "dot negativedot"},
};

// In the order of ComparedBy. The last is for spaces of unit vectors alone.
constexpr Word comparison_table[] = {
    {"own", "as the space has it"},
    {"euclidean", "length of the difference", "l2 length"},
    {"manhattan", "sum of the differences of the channels", "l1 taxicab cityblock"},
    {"chebyshev", "largest difference of a channel", "linf linfinity max maximum"},
    {"cosine", "1 less the cosine of the angle", "dot negativedot"},
};

// In the order of ImageDomain.
constexpr Word domain_table[] = {
    {"square", "[0, 1) in both channels, as texture coordinates: x to the right, y down", "plane rectangle"},
    {"disk", "the unit disk in an image of [-1, 1]: x to the right, y down; its corners are not used", "disc lens"},
    {"sphere", "directions, from an equirectangular image with y up", "equirectangular latlong environment sky"},
    {"hemisphere", "the same image's upper half, y > 0", "dome upper"},
};

// In the order of ImageEncoding.
constexpr Word encoding_table[] = {
    {"unstated", "as linear; where the numbers may be sRGB codes, with a warning"},
    {"linear", "the numbers are light: renderings, measured maps, importance maps", "light none raw"},
    {"srgb", "codes of sRGB, as in pictures to look at", "sRGB gamma"},
};

constexpr Condition with_list = {"texture.samples.space", "file"};
constexpr Condition with_image = {"texture.samples.space", "image"};

void read_samples(Reader& reader, const Found& found) {
  SampleSpec& samples = found.owners.get<RunConfig>().problem.samples;
  if (const Table* table = found.value.table()) {
    samples = {};
    if (find(*table, "space") == nullptr) samples.space = find(*table, "image") != nullptr ? of_image : list_of_own;
    return reader.read_table(found.value, key_of_samples, found.shown, found.owners);
  }
  const std::string* text = found.value.text();
  if (text == nullptr) return reader.fault(found.value, found.shown, "must be " + found.setting.accepted());
  const auto is_text = [&](const Word& word) { return word.word == *text; };
  if (std::none_of(found.setting.words.begin(), found.setting.words.end(), is_text)) {
    return reader.fault(found.value, found.shown, unknown_word(*text, found.setting));
  }
  samples = {};
  const Place& place = found.value.place;
  const Value table{.data = Table{{.key = "space", .place = place, .value = found.value}}, .place = place};
  reader.read_table(table, key_of_samples, found.shown, found.owners);
}

std::string samples_text(const Writer& writer, const Setting& setting, const Owners& owners) {
  const SampleSpec& samples = owners.get<RunConfig>().problem.samples;
  if (samples.is_file() || samples.is_image()) return writer.inline_table(setting.key, owners, "space");
  const bool is_a_word = samples.parameters.empty() && samples.compared_by == ComparedBy::own;
  return is_a_word ? toml_string(samples.space) : writer.inline_table(setting.key, owners);
}

// The fields of the parameters by their number: no space has more.
template <std::size_t index>
Access parameter_field() {
  return [](RunConfig& c) -> Field { return &c.problem.samples.parameters.at(index); };
}

const std::array<Access, 4> parameter_fields = {parameter_field<0>(), parameter_field<1>(), parameter_field<2>(),
                                                parameter_field<3>()};

Setting parameter_row(const SpaceTraits& space, std::size_t index) {
  static std::deque<std::string> keys;  // rows hold views
  const SpaceParameter& parameter = space.parameters[index];
  keys.push_back(std::string(key_of_samples) + '.' + parameter.name);
  return {.key = keys.back(),
          .type = parameter.whole ? Type::integer : Type::number,
          .sentence = parameter.meaning,
          .field = parameter_fields.at(index),
          .range = at_least(parameter.least, parameter.most),
          .unit = parameter.unit,
          .when = {key_of_space, space.name}};
}

// The spaces of that distance, whose samples may be compared by another one.
std::string_view spaces_of(DistanceKind distance) {
  static std::deque<std::string> lists;  // rows hold views
  std::string& list = lists.emplace_back();
  for (const SampleSpace* space : sample_spaces()) {
    if (space->traits().distance == distance) list += (list.empty() ? "" : " ") + space->traits().name;
  }
  return list;
}

Setting comparison_row(DistanceKind own, std::span<const Word> words) {
  return {.key = "texture.samples.distance",
          .type = Type::word,
          .sentence = "How samples are compared, where it is not as the space has it.",
          .field = [](RunConfig& c) -> Field { return &c.problem.samples.compared_by; },
          .words = words,
          .when = {key_of_space, spaces_of(own)},
          .zero_is_unset = true};
}

std::vector<Setting> rows_of_samples() {
  return {
      {.key = "texture.samples",
       .type = Type::custom,
       .sentence = "The values that every slice holds, one from each of as many equal strata as it has pixels.",
       .words = sample_words(),
       .custom = &samples_type},
      {.key = "texture.samples.space",
       .type = Type::word,
       .sentence = "The word, where parameters stand beside it: { space = \"cone\", angle = 30 }. A table with `file` "
                   "or `image` needs none.",
       .field = [](RunConfig& c) -> Field { return &c.problem.samples.space; },
       .words = sample_words(),
       .chosen = take_initial_parameters},
      {.key = "texture.samples.file",
       .type = Type::file,
       .sentence =
           "A .npy of shape [n] or [n, channels] for all slices, or with the number of slices in front; n pixels "
           "in a slice; or of the texture's own shape, [slice axes..., y, x] or with the channels last. Read when a "
           "run begins, and kept in its run file.",
       .field = [](RunConfig& c) -> Field { return &c.problem.samples.file; },
       .when = with_list,
       .required = true},
      {.key = "texture.samples.distance",
       .type = Type::word,
       .sentence = "How samples from a file are compared.",
       .field = [](RunConfig& c) -> Field { return &c.problem.samples.distance; },
       .words = distance_table,
       .when = with_list},
      comparison_row(DistanceKind::euclidean, std::span(comparison_table).first(4)),
      comparison_row(DistanceKind::angle, comparison_table),
      {.key = "texture.samples.image",
       .type = Type::file,
       .sentence =
           "An image whose luminance is the density of the samples: PNG, EXR, HDR, TIFF, or a .npy of shape [height, "
           "width] or with channels last. Read when a run begins; its luminance is kept in the run file.",
       .field = [](RunConfig& c) -> Field { return &c.problem.samples.file; },
       .when = with_image,
       .required = true},
      {.key = "texture.samples.onto",
       .type = Type::word,
       .sentence = "What the image covers.",
       .field = [](RunConfig& c) -> Field { return &c.problem.samples.onto; },
       .words = domain_table,
       .when = with_image},
      {.key = "texture.samples.encoding",
       .type = Type::word,
       .sentence = "How the numbers of the image stand for light; unstated is as linear, with a warning where they may "
                   "be sRGB codes.",
       .field = [](RunConfig& c) -> Field { return &c.problem.samples.encoding; },
       .words = encoding_table,
       .when = with_image},
  };
}

}  // namespace

std::vector<Setting> with_rows_of_samples(std::vector<Setting> rows) {
  std::vector<Setting> own = rows_of_samples();
  for (const SampleSpace* space : sample_spaces()) {
    const SpaceTraits& traits = space->traits();
    for (std::size_t i = 0; i < traits.parameters.size(); ++i) own.push_back(parameter_row(traits, i));
  }
  const auto size = std::find_if(rows.begin(), rows.end(), [](const Setting& s) { return s.key == "texture.size"; });
  rows.insert(std::next(size), own.begin(), own.end());
  return rows;
}

void check_sizes_of_nets(Reader& reader, const Value& root, const RunConfig& config) {
  const SampleSpec& samples = config.problem.samples;
  const Extents& extents = config.problem.extents;
  if (samples.is_file() || samples.is_image() || !space_traits(samples).is_net) return;
  bool are_powers = true;
  for (int axis = 0; axis < extents.num_axes(); ++axis) {
    const std::string key = "texture.size." + extents.name(axis);
    const auto size = static_cast<std::uint64_t>(extents.size(axis));
    const Value* value = find_at(root, key);
    if (value == nullptr || std::has_single_bit(size)) continue;
    are_powers = false;
    reader.fault(*value, key,
                 fmt::format("must be a power of two with samples \"{}\"; the nearest are {} and {}", samples.space,
                             std::bit_floor(size), std::bit_ceil(size)));
  }
  constexpr std::int64_t most = std::int64_t{1} << 23;
  const Value* size = find_at(root, "texture.size");
  if (!are_powers || size == nullptr || extents.num_cells() <= most) return;
  reader.fault(*size, "texture.size",
               fmt::format("{} pixels; samples \"{}\" are at most {}, as float tells no more of them apart",
                           extents.num_cells(), samples.space, most));
}

void take_initial_parameters(const Owners& owners) {
  SampleSpec& samples = owners.get<RunConfig>().problem.samples;
  const SampleSpace* const space = find_sample_space(samples.space);
  samples.parameters = space == nullptr ? std::vector<double>{} : initial_parameters(space->traits());
}

std::span<const Word> sample_words() {
  static const std::vector<Word> words = [] {
    std::vector<Word> all;
    for (const SampleSpace* space : sample_spaces()) {
      const SpaceTraits& traits = space->traits();
      all.push_back({traits.name, traits.meaning, traits.aliases});
    }
    all.push_back({of_image, "points or directions of an image's density: { image = \"sky.exr\", onto = \"sphere\" }",
                   "density picture environment hdri"});
    all.push_back({list_of_own, "a list of your own: { file = \"mine.npy\" }", "list npy"});
    return all;
  }();
  return words;
}

const CustomType samples_type = {
    .accepted =
        [](const Setting& s) { return "one of " + list_of(s.words) + "; or a table, such as { file = \"mine.npy\" }"; },
    .read = read_samples,
    .text = samples_text,
    .help = "one of the words below, or a table",
    .shorthand = "space"};

}  // namespace noiseloom::settings
