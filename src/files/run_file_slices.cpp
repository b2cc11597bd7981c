#include "files/run_file_slices.h"

namespace noiseloom {
namespace {

struct Selection {
  hdf5::Handle file;    // the slice in the dataset
  hdf5::Handle memory;  // the same number of elements in a row
};

Selection select(hid_t id, const SliceDataset& dataset, const Extents& extents, SliceIndex slice,
                 const std::string& what) {
  NOISELOOM_CHECK(extents.slices().contains(slice));
  std::vector<hsize_t> count = dimensions_of(dataset, extents);
  std::vector<hsize_t> start(count.size(), 0);
  const auto num_slice_axes = static_cast<std::size_t>(extents.num_slice_axes());
  const Extents::SliceCoord coord = extents.slice_coord(slice);
  hsize_t elements = 1;
  for (std::size_t i = 0; i < count.size(); ++i) {
    if (i < num_slice_axes) {
      start[i] = narrow<hsize_t>(coord[num_slice_axes - 1 - i]);
      count[i] = 1;
    }
    elements *= count[i];
  }
  Selection selection;
  selection.file = hdf5::Handle(H5Dget_space(id), H5Sclose, what);
  hdf5::checked(H5Sselect_hyperslab(selection.file.id(), H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr),
                what);
  selection.memory = hdf5::Handle(H5Screate_simple(1, &elements, nullptr), H5Sclose, what);
  return selection;
}

}  // namespace

std::size_t bytes_per_element(ElementType type) { return type == ElementType::uint64 ? 8 : 4; }

std::size_t bytes_per_slice(const SliceDataset& dataset, const Extents& extents) {
  return narrow<std::size_t>(extents.cells_per_slice()) * narrow<std::size_t>(dataset.channels) *
         bytes_per_element(dataset.type);
}

std::vector<hsize_t> dimensions_of(const SliceDataset& dataset, const Extents& extents) {
  std::vector<hsize_t> dimensions;
  for (const std::int64_t size : extents.file_dimensions()) dimensions.push_back(narrow<hsize_t>(size));
  if (dataset.channel_axis) dimensions.push_back(narrow<hsize_t>(dataset.channels));
  return dimensions;
}

std::vector<std::string> labels_of(const SliceDataset& dataset, const Extents& extents) {
  std::vector<std::string> labels;
  for (int axis = extents.num_axes() - 1; axis >= 2; --axis) labels.push_back(extents.name(axis));
  labels.insert(labels.end(), {extents.name(1), extents.name(0)});
  if (dataset.channel_axis) labels.emplace_back("channel");
  return labels;
}

hid_t stored_type(ElementType type) {
  switch (type) {
    case ElementType::float32:
      return H5T_IEEE_F32LE;
    case ElementType::uint32:
      return H5T_STD_U32LE;
    case ElementType::uint64:
      return H5T_STD_U64LE;
  }
  return -1;
}

void write_slice(hid_t id, const SliceDataset& dataset, const Extents& extents, SliceIndex slice,
                 std::span<const std::byte> bytes, const std::string& what) {
  NOISELOOM_CHECK_EQ(bytes.size(), bytes_per_slice(dataset, extents));
  const Selection selection = select(id, dataset, extents, slice, what);
  hdf5::checked(
      H5Dwrite(id, stored_type(dataset.type), selection.memory.id(), selection.file.id(), H5P_DEFAULT, bytes.data()),
      what);
}

void read_slice(hid_t id, const SliceDataset& dataset, const Extents& extents, SliceIndex slice,
                std::span<std::byte> bytes, const std::string& what) {
  NOISELOOM_CHECK_EQ(bytes.size(), bytes_per_slice(dataset, extents));
  const Selection selection = select(id, dataset, extents, slice, what);
  hdf5::checked(
      H5Dread(id, stored_type(dataset.type), selection.memory.id(), selection.file.id(), H5P_DEFAULT, bytes.data()),
      what);
}

}  // namespace noiseloom
