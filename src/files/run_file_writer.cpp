// Writing a run file. Everything but slices and checksums is written first, /provenance last of that, so that no
// address depends on what may differ between equal runs.
#include <algorithm>
#include <bit>

#include "files/attempt.h"
#include "files/hdf5_driver.h"
#include "files/run_file_block.h"
#include "files/run_file_slices.h"
#include "noiseloom/files/digest.h"
#include "noiseloom/files/generations.h"
#include "noiseloom/files/run_file.h"

namespace noiseloom {
namespace {

static_assert(std::endian::native == std::endian::little, "slices and checksums lie in the file as in memory");

constexpr std::string_view seconds_column = "seconds";

struct OpenDataset {
  SliceDataset spec;
  hdf5::Handle data;
  hdf5::Handle checksums;
  SlicePlace place;
  std::vector<std::uint64_t> digests;
  std::vector<bool> written;
};

// The key of the combined checksum of "/samples" under /checksum.
std::string checksum_key(const std::string& dataset) { return dataset.substr(1); }

std::string combined(const OpenDataset& dataset) {
  NOISELOOM_CHECK(std::ranges::all_of(dataset.written, std::identity{}));
  return to_hex(digest_of(std::as_bytes(std::span(dataset.digests))));
}

std::uint64_t offset_of(hid_t dataset, const std::string& what) {
  const haddr_t offset = H5Dget_offset(dataset);
  if (offset == HADDR_UNDEF) hdf5::fail(what);
  return offset;
}

}  // namespace

struct RunFileWriter::Impl {
  Impl(FileOps& file_ops, const std::string& target, const RunFileContent& content)
      : ops(file_ops), path(follow_links(target)), temporary(temporary_name(path)), extents(content.extents) {
    fd = ops.create(temporary);
    try {
      create_structure(content);
    } catch (...) {
      discard();
      throw;
    }
  }
  ~Impl() { discard(); }

  void create_structure(const RunFileContent& content);
  void create_file();
  void create_dataset(const SliceDataset& spec);
  void write_inputs(const RunFileContent& content);
  void write_history(const RunFileContent& content);
  void write_provenance(const RunFileContent& content);
  void write_checksums();
  void close_hdf5();
  void write_block();
  void discard() noexcept;
  hdf5::Location location() const { return {file.id(), temporary}; }

  FileOps& ops;
  std::string path;
  std::string temporary;
  Extents extents;
  int fd = -1;
  bool published = false;
  std::uint64_t block_bytes = 0;
  std::shared_ptr<hdf5::DriverFile> driver;
  hdf5::Handle file;
  std::vector<OpenDataset> datasets;
};

void RunFileWriter::Impl::create_structure(const RunFileContent& content) {
  const hdf5::Quiet quiet;
  std::vector<std::string> names;
  for (const SliceDataset& spec : content.datasets) {
    NOISELOOM_CHECK(spec.name.starts_with('/') && spec.name.find_first_of(" \n") == std::string::npos);
    NOISELOOM_CHECK(spec.channels >= 1 && (spec.channel_axis || spec.channels == 1));
    names.push_back(spec.name);
  }
  block_bytes = block_bytes_for(names);
  create_file();
  const hdf5::Location at = location();
  std::vector<std::int64_t> sizes;
  std::string axes;
  for (int axis = 0; axis < extents.num_axes(); ++axis) {
    sizes.push_back(extents.size(axis));
    axes += (axis > 0 ? " " : "") + extents.name(axis);
  }
  hdf5::write_attribute(at, "/", "format", std::int64_t{run_file_format});
  hdf5::write_attribute(at, "/", "axes", axes);
  hdf5::write_attribute(at, "/", "extents", sizes);
  hdf5::create_group(at, "/state");
  for (const auto& [key, value] : content.state) hdf5::write_attribute(at, "/state", key, value);
  hdf5::create_group(at, "/checksum");
  for (const SliceDataset& spec : content.datasets) create_dataset(spec);
  hdf5::write_text(at, "/config", content.config);
  write_inputs(content);
  write_history(content);
  write_provenance(content);
  driver->rethrow();
}

void RunFileWriter::Impl::create_file() {
  const std::string what = temporary + ": cannot describe the HDF5 file";
  const hdf5::Handle creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose, what);
  hdf5::checked(H5Pset_userblock(creation.id(), block_bytes), what);
  hdf5::checked(H5Pset_obj_track_times(creation.id(), false), what);
  const hdf5::Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, what);
  hdf5::checked(H5Pset_libver_bounds(access.id(), H5F_LIBVER_V110, H5F_LIBVER_V110), what);
  driver = std::make_shared<hdf5::DriverFile>(ops, fd);
  file = hdf5::create_file(driver, temporary, creation.id(), access.id());
}

void RunFileWriter::Impl::create_dataset(const SliceDataset& spec) {
  const hdf5::Location at = location();
  const auto num_slices = narrow<std::size_t>(extents.num_slices());
  OpenDataset dataset;
  dataset.spec = spec;
  dataset.digests.resize(num_slices);
  dataset.written.resize(num_slices);
  hdf5::create_parents(at, spec.name);
  dataset.data = hdf5::create_dataset(at, spec.name, stored_type(spec.type), dimensions_of(spec, extents));
  hdf5::write_dimension_labels(at, dataset.data.id(), labels_of(spec, extents));
  hdf5::create_parents(at, checksum_path(spec.name));
  dataset.checksums = hdf5::create_dataset(at, checksum_path(spec.name), H5T_STD_U64LE, {num_slices});
  // Takes its room now; the value follows when all slices are there.
  hdf5::write_attribute(at, "/checksum", checksum_key(spec.name), to_hex(0));
  dataset.place = {spec.name, offset_of(dataset.data.id(), temporary + ": no place in the file for " + spec.name),
                   num_slices, bytes_per_slice(spec, extents),
                   offset_of(dataset.checksums.id(), temporary + ": no place in the file for checksums")};
  datasets.push_back(std::move(dataset));
}

void RunFileWriter::Impl::write_inputs(const RunFileContent& content) {
  if (content.inputs.empty()) return;
  const hdf5::Location at = location();
  hdf5::create_group(at, "/inputs", true);
  for (const RunFileInput& input : content.inputs) {
    const std::string name = "/inputs/" + input.key;
    hdf5::write_array(at, name, *input.array);
    hdf5::write_attribute(at, name, "file", input.file);
  }
}

void RunFileWriter::Impl::write_history(const RunFileContent& content) {
  const hdf5::Location at = location();
  hdf5::create_group(at, "/history", true);
  for (const auto& [column, values] : content.history) {
    NOISELOOM_CHECK_EQ(values.size(), content.history.front().second.size());
    if (column != seconds_column) {
      hdf5::write_numbers(at, "/history/" + column, values);
    } else {
      hdf5::checked(H5Lcreate_soft(("/provenance/" + column).c_str(), file.id(), ("/history/" + column).c_str(),
                                   H5P_DEFAULT, H5P_DEFAULT),
                    temporary + ": cannot link /history/" + column);
    }
  }
}

void RunFileWriter::Impl::write_provenance(const RunFileContent& content) {
  const hdf5::Location at = location();
  hdf5::create_group(at, "/provenance");
  for (const auto& [key, value] : content.provenance) hdf5::write_attribute(at, "/provenance", key, value);
  for (const auto& [column, values] : content.history) {
    if (column == seconds_column) hdf5::write_numbers(at, "/provenance/" + column, values);
  }
}

void RunFileWriter::Impl::write_checksums() {
  const std::string what = temporary + ": cannot write /checksum";
  const hdf5::Handle group(H5Gopen2(file.id(), "/checksum", H5P_DEFAULT), H5Gclose, what);
  for (const OpenDataset& dataset : datasets) {
    const std::string value = combined(dataset);
    hdf5::checked(
        H5Dwrite(dataset.checksums.id(), H5T_STD_U64LE, H5S_ALL, H5S_ALL, H5P_DEFAULT, dataset.digests.data()), what);
    const hdf5::Handle attribute(H5Aopen(group.id(), checksum_key(dataset.spec.name).c_str(), H5P_DEFAULT), H5Aclose,
                                 what);
    const hdf5::Handle type(H5Aget_type(attribute.id()), H5Tclose, what);
    hdf5::checked(H5Awrite(attribute.id(), type.id(), value.data()), what);
  }
}

void RunFileWriter::Impl::close_hdf5() {
  const std::string what = temporary + ": cannot close";
  for (OpenDataset& dataset : datasets) {
    dataset.data.close(what);
    dataset.checksums.close(what);
  }
  file.close(what);
  driver->rethrow();
}

void RunFileWriter::Impl::write_block() {
  RunFileBlock block;
  block.block_bytes = block_bytes;
  block.length = ops.size(fd);
  for (const OpenDataset& dataset : datasets) block.slices.push_back(dataset.place);
  block.outside_slices = ranges_outside_slices(block);
  for (OutsideRange& place : block.outside_slices) place.digest = digest_of_range(ops, fd, place.begin, place.end);
  const std::string text = to_text(block);
  ops.write(fd, 0, std::as_bytes(std::span(text)));
}

void RunFileWriter::Impl::discard() noexcept {
  const hdf5::Quiet quiet;
  if (driver) driver->abandon();
  datasets.clear();
  file = {};
  if (fd >= 0) attempt([&] { ops.close(std::exchange(fd, -1)); });
  if (!published) attempt([&] { ops.remove(temporary); });
}

RunFileWriter::RunFileWriter(FileOps& ops, const std::string& path, const RunFileContent& content)
    : impl_(std::make_unique<Impl>(ops, path, content)) {}

RunFileWriter::~RunFileWriter() = default;

void RunFileWriter::write_slice(int dataset, SliceIndex slice, std::span<const std::byte> bytes) {
  const hdf5::Quiet quiet;
  OpenDataset& target = impl_->datasets.at(narrow<std::size_t>(dataset));
  const auto index = narrow<std::size_t>(slice);
  NOISELOOM_CHECK(index < target.written.size() && !target.written[index]);
  noiseloom::write_slice(target.data.id(), target.spec, impl_->extents, slice, bytes,
                         impl_->temporary + ": cannot write a slice of " + target.spec.name);
  impl_->driver->rethrow();
  target.digests[index] = digest_of(bytes);
  target.written[index] = true;
}

void RunFileWriter::complete() {
  const hdf5::Quiet quiet;
  impl_->write_checksums();
  impl_->close_hdf5();
  impl_->write_block();
  impl_->ops.sync(impl_->fd);
  impl_->ops.close(std::exchange(impl_->fd, -1));
}

void RunFileWriter::publish() {
  if (impl_->fd >= 0) complete();
  publish_generation(impl_->ops, impl_->temporary, impl_->path);
  impl_->published = true;
}

std::string RunFileWriter::checksum(int dataset) const {
  return combined(impl_->datasets.at(narrow<std::size_t>(dataset)));
}

}  // namespace noiseloom
