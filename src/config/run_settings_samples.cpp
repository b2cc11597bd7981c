// The setting texture.samples: the word of a sample space, or a table that holds it and what goes with it: the
// parameters of the space, or a list of the user's own. Every parameter that a space declares (samples/space.h) is a
// row of the config's table.
#include <algorithm>
#include <array>
#include <cstddef>
#include <deque>
#include <string>
#include <utility>

#include "config/run_settings.h"
#include "noiseloom/config/settings_writer.h"
#include "noiseloom/samples/space.h"

namespace noiseloom::settings {
namespace {

constexpr std::string_view key_of_samples = "texture.samples";
constexpr std::string_view key_of_space = "texture.samples.space";
constexpr std::string_view list_of_own = "file";  // the word of SampleSpec::is_file

void read_samples(Reader& reader, const Found& found) {
  SampleSpec& samples = found.owners.get<RunConfig>().problem.samples;
  if (const Table* table = found.value.table()) {
    if (const Value* image = find(*table, "image")) {
      return reader.fault(*image, found.shown + ".image", "planned, but this version does not have it");
    }
    samples = {};
    if (find(*table, "space") == nullptr) samples.space = list_of_own;
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
  if (samples.is_file()) return writer.inline_table(setting.key, owners, "space");
  return samples.parameters.empty() ? toml_string(samples.space) : writer.inline_table(setting.key, owners);
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

}  // namespace

std::vector<Setting> with_parameters_of_samples(std::vector<Setting> rows) {
  std::vector<Setting> parameters;
  for (const SampleSpace* space : sample_spaces()) {
    const SpaceTraits& traits = space->traits();
    for (std::size_t i = 0; i < traits.parameters.size(); ++i) parameters.push_back(parameter_row(traits, i));
  }
  const auto last =
      std::find_if(rows.rbegin(), rows.rend(), [](const Setting& s) { return s.parent() == key_of_samples; });
  rows.insert(last.base(), parameters.begin(), parameters.end());
  return rows;
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
