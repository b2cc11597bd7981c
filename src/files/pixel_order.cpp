#include "noiseloom/files/pixel_order.h"

#include <fmt/format.h>

#include <algorithm>

namespace noiseloom {
std::string why_no_order(const RunFileContent& content) {
  const auto found = std::ranges::find(content.datasets, "/order", &SliceDataset::name);
  if (found == content.datasets.end())
    return "holds no /order, the sequence of its pixels: only masks of method \"void-and-cluster\" have one";
  if (found->type == ElementType::float32 || found->channels != 1)
    return "/order is no list of ranks (uint32 or uint64, one a pixel)";
  return "";
}

PixelOrder::PixelOrder(const RunFileReader& reader, const std::string& path)
    : reader_(reader), path_(path), dataset_(reader.dataset("/order")) {
  if (const std::string why = why_no_order(reader.content()); !why.empty()) throw UserError(path, why);
  require_all_ranked();
}

void PixelOrder::read_slice(SliceIndex slice, std::span<std::uint64_t> ranks) const {
  const SliceDataset& dataset = reader_.content().datasets[static_cast<std::size_t>(dataset_)];
  if (dataset.type == ElementType::uint64) {
    reader_.read_slice(dataset_, slice, std::as_writable_bytes(ranks));
    return;
  }
  std::vector<std::uint32_t> narrow_ranks(ranks.size());
  reader_.read_slice(dataset_, slice, std::as_writable_bytes(std::span(narrow_ranks)));
  std::copy(narrow_ranks.begin(), narrow_ranks.end(), ranks.begin());
}

// Pixels without a rank hold values that no rank has (construct/void_and_cluster.h).
void PixelOrder::require_all_ranked() const {
  const Extents& extents = reader_.content().extents;
  std::vector<std::uint64_t> ranks(static_cast<std::size_t>(extents.cells_per_slice()));
  std::int64_t num_ranked = 0;
  for (SliceIndex s = 0; s < extents.num_slices(); ++s) {
    read_slice(s, ranks);
    num_ranked += std::count_if(ranks.begin(), ranks.end(), [&](std::uint64_t rank) {
      return rank < static_cast<std::uint64_t>(extents.num_cells());
    });
  }
  if (num_ranked < extents.num_cells())
    throw UserError(path_, fmt::format("not finished: {} of {} pixels have their place in the order; go on with "
                                       "generate --resume",
                                       num_ranked, extents.num_cells()));
}

}  // namespace noiseloom
