#include "noiseloom/files/pixel_order.h"

#include <vector>

namespace noiseloom {

PixelOrder::PixelOrder(const RunFileReader& reader, const std::string& path)
    : reader_(reader), dataset_(reader.dataset(order_name)) {
  if (const std::string why = why_order_cannot_be_read(reader.content()); !why.empty()) throw UserError(path, why);
  require_complete_order(census_of_order(reader), path);
}

void PixelOrder::read_slice(SliceIndex slice, std::span<std::uint64_t> places) const {
  const SliceDataset& dataset = reader_.content().datasets[static_cast<std::size_t>(dataset_)];
  std::vector<std::byte> bytes(bytes_per_slice(dataset, reader_.content().extents));
  reader_.read_slice(dataset_, slice, bytes);
  OrderCodec(dataset.type).read(bytes, places);
}

}  // namespace noiseloom
