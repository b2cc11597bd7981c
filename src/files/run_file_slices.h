// Slice datasets between memory and HDF5.
#pragma once

#include "files/hdf5_objects.h"
#include "noiseloom/files/run_file.h"

namespace noiseloom {

// Dimensions in file order and their labels: [slice axes..., y, x] and the channel axis if there is one.
std::vector<hsize_t> dimensions_of(const SliceDataset& dataset, const Extents& extents);
std::vector<std::string> labels_of(const SliceDataset& dataset, const Extents& extents);

hid_t stored_type(ElementType type);

void write_slice(hid_t id, const SliceDataset& dataset, const Extents& extents, SliceIndex slice,
                 std::span<const std::byte> bytes, const std::string& what);
void read_slice(hid_t id, const SliceDataset& dataset, const Extents& extents, SliceIndex slice,
                std::span<std::byte> bytes, const std::string& what);

}  // namespace noiseloom
