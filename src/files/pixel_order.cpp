#include "noiseloom/files/pixel_order.h"

#include <vector>

namespace noiseloom {

PixelOrder::PixelOrder(const RunFileReader& reader, const std::string& path)
    : reader_(reader), dataset_(reader.dataset(order_name)) {
  if (const std::string why = why_order_cannot_be_read(reader.content()); !why.empty()) throw UserError(path, why);
  require_complete_order(census_of_order(reader), path);
}

void PixelOrder::read_slice(SliceIndex slice, std::span<OrderPlace> places) const {
  const SliceDataset& dataset = reader_.content().datasets[static_cast<std::size_t>(dataset_)];
  std::vector<std::byte> bytes(bytes_per_slice(dataset, reader_.content().extents));
  reader_.read_slice(dataset_, slice, bytes);
  const OrderCodec codec(dataset.type);
  NOISELOOM_CHECK_EQ(places.size(), codec.num_pixels(bytes));
  for (std::size_t cell = 0; cell < places.size(); ++cell) places[cell] = OrderPlace(codec.get(bytes, cell));
}

}  // namespace noiseloom
