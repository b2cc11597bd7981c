// Reading a run file: digests first, then HDF5 on the same descriptor, so that what is read is what was checked.
#include <algorithm>
#include <filesystem>
#include <sstream>

#include "files/hdf5_driver.h"
#include "files/run_file_block.h"
#include "files/run_file_slices.h"
#include "noiseloom/files/run_file.h"

namespace noiseloom {
namespace {

// A descriptor of the real file system.
class OpenedFile {
 public:
  explicit OpenedFile(const std::string& path) : fd_(posix_file_ops().open(path)) {}
  ~OpenedFile() {
    try {
      posix_file_ops().close(fd_);
    } catch (const EnvironmentError&) {  // nothing was written
    }
  }
  OpenedFile(const OpenedFile&) = delete;
  OpenedFile& operator=(const OpenedFile&) = delete;
  int fd() const { return fd_; }

 private:
  int fd_;
};

void require_file(const std::string& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (status.type() == std::filesystem::file_type::not_found) throw UserError(path, "there is no such file");
  if (error) throw EnvironmentError(path + ": cannot look up: " + error.message());
  if (!std::filesystem::is_regular_file(status)) throw UserError(path, "a folder or device, not a noiseloom run file");
}

Extents read_extents(const hdf5::Location& at) {
  std::istringstream axes(std::get<std::string>(hdf5::read_attribute(at, "/", "axes")));
  std::vector<std::string> names;
  for (std::string name; axes >> name;) names.push_back(name);
  return Extents(hdf5::read_integers(at, "/", "extents"), names);
}

ElementType element_type_of(hid_t dataset, const std::string& what) {
  const hdf5::Handle type(H5Dget_type(dataset), H5Tclose, what);
  for (const ElementType candidate : {ElementType::float32, ElementType::uint32, ElementType::uint64}) {
    if (hdf5::checked(H5Tequal(type.id(), stored_type(candidate)), what) > 0) return candidate;
  }
  throw EnvironmentError(what + ": its type is none that a run file has");
}

SliceDataset describe(const hdf5::Location& at, const std::string& name, hid_t dataset, const Extents& extents) {
  const std::vector<hsize_t> dimensions = hdf5::dimensions_of(at, dataset);
  SliceDataset spec;
  spec.name = name;
  spec.type = element_type_of(dataset, at.name + ": cannot read " + name);
  spec.channel_axis = dimensions.size() > narrow<std::size_t>(extents.num_axes());
  if (spec.channel_axis) spec.channels = narrow<int>(dimensions.back());
  if (dimensions != dimensions_of(spec, extents)) {
    throw EnvironmentError(at.name + ": " + name + " does not have the extents of the texture");
  }
  return spec;
}

}  // namespace

struct RunFileReader::Impl {
  explicit Impl(const std::string& file_path) : path(file_path), opened(file_path) {}
  void read_all(const RunFileBlock& block);

  std::string path;
  OpenedFile opened;
  hdf5::Handle file;
  std::vector<hdf5::Handle> datasets;
  RunFileContent content;
};

void RunFileReader::Impl::read_all(const RunFileBlock& block) {
  const std::string what = path + ": cannot open";
  const hdf5::Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, what);
  file = hdf5::open_file(std::make_shared<hdf5::DriverFile>(posix_file_ops(), opened.fd()), path, access.id());
  const hdf5::Location at{file.id(), path};
  content.extents = read_extents(at);
  content.config = hdf5::read_text(at, "/config");
  content.state = hdf5::read_attributes(at, "/state");
  content.provenance = hdf5::read_attributes(at, "/provenance");
  for (const std::string& column : hdf5::links_in_order(at, "/history")) {
    content.history.emplace_back(column, hdf5::read_numbers(at, "/history/" + column));
  }
  const std::map<std::string, Attribute> checksums = hdf5::read_attributes(at, "/checksum");
  for (const SlicePlace& place : block.slices) {
    datasets.push_back(hdf5::open_dataset(at, place.name));
    content.datasets.push_back(describe(at, place.name, datasets.back().id(), content.extents));
    content.checksums[place.name] = std::get<std::string>(checksums.at(place.name.substr(1)));
  }
}

RunFileReader::RunFileReader(const std::string& path) {
  const hdf5::Quiet quiet;
  require_file(path);
  impl_ = std::make_unique<Impl>(path);
  const RunFileBlock block = verify_run_file(posix_file_ops(), impl_->opened.fd(), path);
  try {
    impl_->read_all(block);
  } catch (const std::logic_error& error) {  // a missing attribute or one of another type
    throw EnvironmentError(path + ": sound, but not laid out like a run file: " + error.what());
  }
}

RunFileReader::~RunFileReader() = default;
RunFileReader::RunFileReader(RunFileReader&&) noexcept = default;

const RunFileContent& RunFileReader::content() const { return impl_->content; }

int RunFileReader::dataset(const std::string& name) const {
  const auto found = std::ranges::find(impl_->content.datasets, name, &SliceDataset::name);
  return found == impl_->content.datasets.end() ? -1 : static_cast<int>(found - impl_->content.datasets.begin());
}

void RunFileReader::read_slice(int dataset, SliceIndex slice, std::span<std::byte> bytes) const {
  const hdf5::Quiet quiet;
  const SliceDataset& spec = impl_->content.datasets.at(narrow<std::size_t>(dataset));
  noiseloom::read_slice(impl_->datasets[narrow<std::size_t>(dataset)].id(), spec, impl_->content.extents, slice, bytes,
                        impl_->path + ": cannot read a slice of " + spec.name);
}

bool looks_like_run_file(const std::string& path) {
  try {
    require_file(path);
    const OpenedFile file(path);
    return begins_like_run_file(posix_file_ops(), file.fd());
  } catch (const std::runtime_error&) {
    return false;
  }
}

}  // namespace noiseloom
