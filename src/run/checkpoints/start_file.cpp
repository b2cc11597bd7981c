#include "run/checkpoints/start_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "noiseloom/files/input_array.h"
#include "noiseloom/files/npy.h"
#include "noiseloom/files/run_file.h"
#include "run/checkpoints/checkpoint_parts.h"

namespace noiseloom {
namespace {

// Rank 0's view of the file: samples of a slice, [y][x][channel].
class Arrangement {
 public:
  Arrangement(const std::string& path, const Extents& extents, int channels) : path_(path) {
    if (looks_like_run_file(path)) {
      open_run_file(extents, channels);
    } else {
      read_array(extents, channels);
    }
  }

  void read_slice(SliceIndex slice, std::span<std::byte> bytes) const {
    if (run_) return run_->read_slice(run_->dataset(samples_name), slice, bytes);
    const auto* const values = std::get<SharedValues<float>>(array_->values).data();
    const std::size_t floats = bytes.size() / sizeof(float);
    std::memcpy(bytes.data(), values + static_cast<std::size_t>(slice) * floats, bytes.size());
  }

 private:
  void open_run_file(const Extents& extents, int channels) {
    run_.emplace(path_, Changed::accepted);
    const RunFileContent& content = run_->content();
    const int samples = run_->dataset(samples_name);
    const SliceDataset wanted{samples_name, ElementType::float32, channels, true};
    const bool fits = samples >= 0 && content.datasets[static_cast<std::size_t>(samples)] == wanted;
    if (fits && content.extents == extents) return;
    throw UserError(path_, fmt::format("holds {}{}; the texture is {} of {} channels", content.extents.to_string(),
                                       fits ? "" : " of other samples", extents.to_string(), channels));
  }

  void read_array(const Extents& extents, int channels) {
    std::vector<std::int64_t> wanted;
    for (int axis = 2; axis < extents.num_axes(); ++axis) wanted.push_back(extents.size(axis));
    wanted.push_back(extents.height());
    wanted.push_back(extents.width());
    std::vector<std::int64_t> with_channels = wanted;
    with_channels.push_back(channels);
    const std::vector<std::int64_t> shape = read_npy_shape(path_);
    const bool fits = shape == with_channels || (channels == 1 && shape == wanted);
    if (!fits) {
      throw UserError(path_,
                      fmt::format("shape {}; a texture of {} is {}{}", npy_shape_text(shape), extents.to_string(),
                                  npy_shape_text(with_channels), channels == 1 ? " or " + npy_shape_text(wanted) : ""));
    }
    array_ = read_float_array(path_);
  }

  std::string path_;
  std::optional<RunFileReader> run_;
  InputArrayPtr array_;
};

// Cells or ids in the order of their samples' bits.
std::vector<std::uint32_t> in_order(const std::vector<float>& samples, std::size_t channels) {
  std::vector<std::uint32_t> order(samples.size() / channels);
  std::iota(order.begin(), order.end(), 0U);
  const auto compare = [&](std::uint32_t a, std::uint32_t b) {
    return std::memcmp(&samples[a * channels], &samples[b * channels], channels * sizeof(float));
  };
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return compare(a, b) < 0; });
  return order;
}

}  // namespace

Permutation ids_of_arrangement(const std::vector<float>& arrangement, const std::vector<float>& list, int channels) {
  if (arrangement.size() != list.size()) return {};
  const auto width = static_cast<std::size_t>(channels);
  const std::vector<std::uint32_t> cells = in_order(arrangement, width);
  const std::vector<std::uint32_t> ids = in_order(list, width);
  Permutation id_at(cells.size());
  for (std::size_t k = 0; k < cells.size(); ++k) {
    if (std::memcmp(&arrangement[cells[k] * width], &list[ids[k] * width], width * sizeof(float)) != 0) return {};
    id_at[cells[k]] = SampleId(ids[k]);
  }
  return id_at;
}

StartFile::StartFile(const std::string& path, const Extents& extents, const SampleSource& source,
                     std::vector<SliceIndex> wanted, const Communicator& communicator) {
  std::optional<Arrangement> file;
  communicator.on_root([&] { file.emplace(path, extents, source.channels()); });
  std::sort(wanted.begin(), wanted.end());
  const std::size_t floats =
      static_cast<std::size_t>(extents.cells_per_slice()) * static_cast<std::size_t>(source.channels());
  std::vector<Fault> faults;
  constexpr std::size_t most_faults = 5;
  const auto produce = [&](SliceIndex slice, std::vector<std::byte>& block) {
    block.resize(floats * sizeof(float));
    file->read_slice(slice, block);
  };
  const auto consume = [&](SliceIndex slice, std::span<const std::byte> block) {
    std::vector<float> samples(floats);
    std::memcpy(samples.data(), block.data(), block.size());
    Permutation ids = ids_of_arrangement(samples, source.list(slice), source.channels());
    if (ids.empty() && faults.size() < most_faults) {
      faults.push_back({path, fmt::format("slice {}: does not hold the samples of texture.samples, bit for bit; to "
                                          "arrange its own anew, name it in texture.samples, too",
                                          slice.value())});
    }
    permutations_[slice] = std::move(ids);
  };
  communicator.stream_from_root(wanted, produce, consume);
  communicator.together([&] { throw_if_any(std::move(faults)); });
}

}  // namespace noiseloom
