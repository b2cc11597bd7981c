#include "noiseloom/config/inputs.h"

#include <fmt/format.h>

#include <algorithm>

#include "noiseloom/core/extents.h"
#include "noiseloom/files/npy.h"
#include "noiseloom/samples/luminance.h"

namespace noiseloom {
namespace {

enum class Contents { samples, density, taps };

// One file that a config names, and where the config keeps what it holds. `Config` is RunConfig or const RunConfig.
template <class Config, class Visit>
void for_each_file(Config& config, const Visit& visit) {
  auto& samples = config.problem.samples;
  if (samples.is_file()) visit("texture.samples.file", Contents::samples, samples.file, samples.array);
  if (samples.is_image()) visit("texture.samples.image", Contents::density, samples.file, samples.array);
  auto& groups = config.problem.filter.groups;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    auto& kernel = groups[g].kernel;
    if (kernel.kind != KernelKind::table) continue;
    visit(fmt::format("filter.groups[{}].file", g), Contents::taps, kernel.file, kernel.array);
  }
}

// A list that is a whole texture has the texture's own axes: another order of them would give slices each other's
// lists.
void check_texture_shape(const RunConfig& config) {
  const SampleSpec& samples = config.problem.samples;
  if (!samples.is_file() || !samples.array) return;
  const Extents& extents = config.problem.extents;
  const std::vector<std::int64_t>& shape = samples.array->shape;
  const std::int64_t n = extents.cells_per_slice();
  const bool is_list =
      shape.empty() || shape[0] == n || (shape[0] == extents.num_slices() && shape.size() > 1 && shape[1] == n);
  if (is_list || shape.size() < 2) return;
  std::vector<std::int64_t> own;
  for (int axis = 2; axis < extents.num_axes(); ++axis) own.push_back(extents.size(axis));
  own.push_back(extents.height());
  own.push_back(extents.width());
  if (shape == own) return;
  const std::string accepted = npy_shape_text(own);
  own.push_back(shape.back());
  if (shape == own) return;
  // Whoever reads it refuses what has another number of values.
  std::int64_t values = 1;
  for (const std::int64_t size : shape) values *= size;
  if (values % extents.num_cells() != 0) return;
  throw UserError(samples.file,
                  fmt::format("shape {}: as a whole texture it must be {}, or that with the channels last",
                              npy_shape_text(shape), accepted));
}

std::string spelt(const RunConfig& config, const std::string& path) {
  const auto found = config.written_paths.find(path);
  return found == config.written_paths.end() ? path : found->second;
}

InputArrayPtr read(const RunConfig& config, Contents contents, const std::string& path) {
  if (contents == Contents::density) return read_luminance(config.problem.samples);
  return contents == Contents::samples ? read_float_array(path) : read_double_array(path);
}

Contents contents_of(const std::string& key) {
  if (key == "texture.samples.image") return Contents::density;
  return key == "texture.samples.file" ? Contents::samples : Contents::taps;
}

bool are_floats(Contents contents) { return contents != Contents::taps; }

bool is_of_type(Contents contents, const InputArray& array) {
  return std::holds_alternative<SharedValues<float>>(array.values) == are_floats(contents) &&
         (contents != Contents::density || array.shape.size() == 2);
}

std::uint64_t num_values(const std::vector<std::int64_t>& shape) {
  std::uint64_t values = 1;
  for (const std::int64_t size : shape) values *= narrow<std::uint64_t>(size);
  return values;
}

// The shape of each file's contents: of what the config holds, else of what its header says. An image is read whole.
void for_each_shape(const RunConfig& config,
                    const std::function<void(Contents, const std::vector<std::int64_t>& shape)>& visit) {
  for_each_file(config,
                [&](const std::string&, Contents contents, const std::string& path, const InputArrayPtr& array) {
                  visit(contents, array                           ? array->shape
                                  : contents == Contents::density ? read(config, contents, path)->shape
                                                                  : read_npy_shape(path));
                });
}

}  // namespace

void read_inputs(RunConfig& config) {
  std::vector<Fault> faults;
  for_each_file(config, [&](const std::string&, Contents contents, const std::string& path, InputArrayPtr& array) {
    if (array) return;
    try {
      array = read(config, contents, path);
    } catch (const UserError& error) {
      faults.insert(faults.end(), error.faults().begin(), error.faults().end());
    }
  });
  throw_if_any(std::move(faults));
  check_texture_shape(config);
}

std::vector<RunFileInput> inputs_of(const RunConfig& config) {
  std::vector<RunFileInput> inputs;
  for_each_file(config, [&](const std::string& key, Contents, const std::string& path, const InputArrayPtr& array) {
    if (array) inputs.push_back({key, spelt(config, path), array});
  });
  return inputs;
}

std::uint64_t inputs_bytes(const RunConfig& config) {
  std::uint64_t bytes = 0;
  for_each_shape(config, [&](Contents contents, const std::vector<std::int64_t>& shape) {
    constexpr std::uint64_t structure = 1024;
    bytes += structure + num_values(shape) * (are_floats(contents) ? sizeof(float) : sizeof(double));
  });
  return bytes;
}

double inputs_memory(const RunConfig& config) {
  double bytes = 0;
  for_each_shape(config, [&](Contents contents, const std::vector<std::int64_t>& shape) {
    const auto values = static_cast<double>(num_values(shape));
    bytes += values * (are_floats(contents) ? sizeof(float) : sizeof(double));
    if (contents == Contents::density) bytes += values * sizeof(std::uint64_t);
  });
  return bytes;
}

void take_inputs(RunConfig& config, const std::vector<RunFileInput>& inputs, const std::string& path) {
  for_each_file(config, [&](const std::string&, Contents contents, const std::string& file, InputArrayPtr& array) {
    const std::string name = spelt(config, file);
    const auto found = std::find_if(inputs.begin(), inputs.end(), [&](const RunFileInput& input) {
      return input.file == name && contents_of(input.key) == contents;
    });
    if (found == inputs.end()) return;
    if (!is_of_type(contents, *found->array)) {
      const bool holds_floats = std::holds_alternative<SharedValues<float>>(found->array->values);
      throw UserError(path,
                      holds_floats != are_floats(contents)
                          ? fmt::format("/inputs/{}: holds {}, but must be {}", found->key,
                                        holds_floats ? "float32" : "float64", holds_floats ? "float64" : "float32")
                          : fmt::format("/inputs/{}: has shape {}, but must be (height, width)", found->key,
                                        npy_shape_text(found->array->shape)));
    }
    array = found->array;
  });
}

void for_each_input(RunConfig& config, const std::function<void(InputArrayPtr&)>& visit) {
  for_each_file(config, [&](const std::string&, Contents, const std::string&, InputArrayPtr& array) { visit(array); });
}

std::vector<InputNote> notes_on_inputs(const RunConfig& config) {
  std::vector<InputNote> notes;
  for_each_file(config, [&](const std::string& key, Contents contents, const std::string& path,
                            const InputArrayPtr& array) {
    const SampleSpec& samples = config.problem.samples;
    if (contents == Contents::density && samples.encoding == ImageEncoding::unstated && may_hold_codes(path)) {
      notes.push_back(
          {"encoding", fmt::format("{} = \"{}\": its numbers are taken as light, as they are; for a picture that is "
                                   "made to be looked at, encoding = \"srgb\" (\"linear\" says that they are light)",
                                   key, spelt(config, path))});
    }
    if (contents != Contents::taps) return;
    const InputArrayPtr held = array ? array : read(config, contents, path);
    const auto& taps = std::get<SharedValues<double>>(held->values);
    const auto negative = std::count_if(taps.begin(), taps.end(), [](double tap) { return tap < 0; });
    if (negative == 0) return;
    notes.push_back(
        {"negative taps",
         fmt::format("{} = \"{}\": {} of {} taps are negative: the filter subtracts these neighbours, as one "
                     "that sharpens does and one that blurs does not",
                     key, spelt(config, path), negative, taps.size())});
  });
  return notes;
}

std::vector<std::string> changed_inputs(const RunConfig& config) {
  std::vector<std::string> changed;
  for_each_file(config,
                [&](const std::string&, Contents contents, const std::string& path, const InputArrayPtr& array) {
                  // An image is never read again by a run that goes on.
                  if (contents == Contents::density) return;
                  try {
                    if (array && *read(config, contents, path) != *array) changed.push_back(spelt(config, path));
                  } catch (const std::exception&) {  // not there, no such file any more, or too large by now
                  }
                });
  return changed;
}

}  // namespace noiseloom
