// Reading a run file: digests first, then HDF5 on the same descriptor, so that what is read is what was checked. Slices
// of a sound file are read where its block says that they lie; HDF5 is asked for them only where another program has
// rewritten the file, perhaps in pieces or compressed.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>
#include <set>
#include <sstream>

#include "files/hdf5_driver.h"
#include "files/run_file_block.h"
#include "files/run_file_slices.h"
#include "noiseloom/files/digest.h"
#include "noiseloom/files/run_file.h"

namespace noiseloom {
namespace {

class OpenedFile {
 public:
  OpenedFile(FileOps& ops, const std::string& path) : ops_(ops), fd_(ops.open(path)) {}
  ~OpenedFile() {
    try {
      ops_.close(fd_);
    } catch (const EnvironmentError&) {  // nothing was written
    }
  }
  OpenedFile(const OpenedFile&) = delete;
  OpenedFile& operator=(const OpenedFile&) = delete;
  int fd() const { return fd_; }

 private:
  FileOps& ops_;
  int fd_;
};

void require_file(const std::string& path) {
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (status.type() == std::filesystem::file_type::not_found) throw UserError(path, "there is no such file");
  if (error) throw EnvironmentError(path + ": cannot look up: " + error.message());
  if (!std::filesystem::is_regular_file(status)) throw UserError(path, "a folder or device, not a noiseloom run file");
}

// For what has the right digests, or none, and yet cannot have been written by noiseloom.
[[noreturn]] void throw_not_laid_out(const std::string& path, const std::string& text) {
  throw UserError(path, "not laid out like a run file: " + text);
}

Extents read_extents(const hdf5::Location& at) {
  std::istringstream axes(hdf5::read_text_attribute(at, "/", "axes"));
  const std::vector<std::int64_t> sizes = hdf5::read_integers(at, "/", "extents");
  std::vector<std::string> names;
  for (std::string name; axes >> name;) names.push_back(name);
  const auto limit = [&](std::size_t axis) {  // so that cells and slices can be counted
    return axis < 2 ? std::int64_t{1} << 31 : std::int64_t{std::numeric_limits<SliceIndex>::max()};
  };
  bool possible = sizes.size() >= 2 && sizes.size() <= Extents::max_axes && sizes.size() == names.size() &&
                  std::set(names.begin(), names.end()).size() == names.size();
  std::int64_t slices = 1;
  for (std::size_t axis = 0; possible && axis < sizes.size(); ++axis) {
    possible = sizes[axis] >= 1 && sizes[axis] <= limit(axis) / (axis < 2 ? 1 : slices);
    if (axis >= 2 && possible) slices *= sizes[axis];
  }
  if (!possible) throw_not_laid_out(at.name, "axes and extents say no size of a texture");
  return Extents(sizes, names);
}

ElementType element_type_of(hid_t dataset, const std::string& what) {
  const hdf5::Handle type(H5Dget_type(dataset), H5Tclose, what);
  for (const ElementType candidate : {ElementType::float32, ElementType::uint32, ElementType::uint64}) {
    if (hdf5::checked(H5Tequal(type.id(), stored_type(candidate)), what) > 0) return candidate;
  }
  throw UserError("", what + ": its type is none that a run file has");
}

SliceDataset describe(const hdf5::Location& at, const std::string& name, hid_t dataset, const Extents& extents) {
  const std::vector<hsize_t> dimensions = hdf5::dimensions_of(at, dataset);
  constexpr hsize_t most_channels = 1024;
  SliceDataset spec;
  spec.name = name;
  spec.type = element_type_of(dataset, at.name + ": cannot read " + name);
  spec.channel_axis = dimensions.size() > narrow<std::size_t>(extents.num_axes());
  if (spec.channel_axis) spec.channels = static_cast<int>(std::min(dimensions.back(), most_channels));
  if (spec.channels < 1 || dimensions != dimensions_of(spec, extents)) {
    throw_not_laid_out(at.name, name + " does not have the extents of the texture");
  }
  return spec;
}

}  // namespace

struct RunFileReader::Impl {
  Impl(FileOps& file_ops, const std::string& file_path) : ops(file_ops), path(file_path), opened(ops, file_path) {}

  // The datasets that `names` lists; all that /checksum has where it is nullptr.
  void read_all(const std::vector<std::string>* names);
  void check_places(const RunFileBlock& block);
  void check_digests();
  bool is_sound_without_block();
  void close_hdf5();
  void read_slice(std::size_t dataset, SliceIndex slice, std::span<std::byte> bytes) const;

  FileOps& ops;
  std::string path;
  OpenedFile opened;
  std::string change;
  RunFileContent content;
  std::vector<SlicePlace> places;  // of a file as it was written
  hdf5::Handle file;               // of one that another program changed
  std::vector<hdf5::Handle> datasets;
};

void RunFileReader::Impl::read_all(const std::vector<std::string>* names) {
  const std::string what = path + ": cannot open";
  const hdf5::Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, what);
  file = hdf5::open_file(std::make_shared<hdf5::DriverFile>(ops, opened.fd()), path, access.id());
  const hdf5::Location at{file.id(), path};
  content.extents = read_extents(at);
  content.config = hdf5::read_text(at, "/config");
  content.state = hdf5::read_attributes(at, "/state");
  content.provenance = hdf5::read_attributes(at, "/provenance");
  for (const std::string& column : hdf5::links_in_order(at, "/history")) {
    content.history.emplace_back(column, hdf5::read_numbers(at, "/history/" + column));
    if (content.history.back().second.size() != content.history.front().second.size()) {
      throw_not_laid_out(path, "the columns of /history have different lengths");
    }
  }
  if (hdf5::exists(at, "/inputs")) {
    for (const std::string& key : hdf5::links_in_order(at, "/inputs")) {
      const std::string name = "/inputs/" + key;
      content.inputs.push_back({key, hdf5::read_text_attribute(at, name, "file"),
                                std::make_shared<const InputArray>(hdf5::read_array(at, name))});
    }
  }
  std::vector<std::string> all;
  for (const auto& [key, value] : hdf5::read_attributes(at, "/checksum")) {
    if (!std::holds_alternative<std::string>(value)) continue;
    content.checksums["/" + key] = std::get<std::string>(value);
    all.push_back("/" + key);
  }
  for (const std::string& name : names ? *names : all) {
    if (!content.checksums.contains(name)) throw_not_laid_out(path, "/checksum lacks " + name);
    datasets.push_back(hdf5::open_dataset(at, name));
    content.datasets.push_back(describe(at, name, datasets.back().id(), content.extents));
  }
}

// HDF5 and the block must mean the same bytes.
void RunFileReader::Impl::check_places(const RunFileBlock& block) {
  for (std::size_t i = 0; i < block.slices.size(); ++i) {
    const SlicePlace& place = block.slices[i];
    const std::uint64_t slice_bytes = bytes_per_slice(content.datasets[i], content.extents);
    const haddr_t offset = H5Dget_offset(datasets[i].id());
    if (offset != place.offset || slice_bytes != place.slice_bytes ||
        place.num_slices != narrow<std::uint64_t>(content.extents.num_slices())) {
      throw_not_laid_out(path, place.name + " does not lie where the text block says");
    }
  }
  places = block.slices;
}

void RunFileReader::Impl::check_digests() {
  const hdf5::Location at{file.id(), path};
  for (std::size_t i = 0; i < content.datasets.size(); ++i) {
    const SliceDataset& spec = content.datasets[i];
    const std::vector<std::uint64_t> digests = hdf5::read_words(at, checksum_path(spec.name));
    if (digests.size() != narrow<std::size_t>(content.extents.num_slices()) ||
        to_hex(digest_of(std::as_bytes(std::span(digests)))) != content.checksums.at(spec.name)) {
      throw_not_laid_out(path, "/checksum of " + spec.name);
    }
    hdf5::check_claim(at, spec.name, datasets[i].id());
    std::vector<std::byte> bytes(bytes_per_slice(spec, content.extents));
    for (const SliceIndex slice : content.extents.slices()) {
      read_slice(i, slice, bytes);
      if (digest_of(bytes) != digests[narrow<std::size_t>(slice)]) throw_not_laid_out(path, "a slice of " + spec.name);
    }
  }
}

void RunFileReader::Impl::close_hdf5() {
  datasets.clear();
  file = {};
}

void RunFileReader::Impl::read_slice(std::size_t dataset, SliceIndex slice, std::span<std::byte> bytes) const {
  const SliceDataset& spec = content.datasets[dataset];
  NOISELOOM_CHECK(content.extents.slices().contains(slice));
  NOISELOOM_CHECK_EQ(bytes.size(), bytes_per_slice(spec, content.extents));
  if (!places.empty()) {
    ops.read(opened.fd(), places[dataset].offset + narrow<std::uint64_t>(slice) * bytes.size(), bytes);
  } else {
    noiseloom::read_slice(datasets[dataset].id(), spec, content.extents, slice, bytes,
                          path + ": cannot read a slice of " + spec.name);
  }
}

// Does HDF5 read the file all the same, and are the slices what /checksum says?
bool RunFileReader::Impl::is_sound_without_block() {
  try {
    read_all(nullptr);
    check_digests();
    return true;
  } catch (const std::runtime_error&) {
    return false;
  }
}

RunFileReader::RunFileReader(const std::string& path, Changed changed, FileOps& ops) {
  const hdf5::Quiet quiet;
  require_file(path);
  impl_ = std::make_unique<Impl>(ops, path);
  std::optional<RunFileBlock> block;
  try {
    block = verify_run_file(ops, impl_->opened.fd(), path);
  } catch (const DamagedRunFile& damage) {
    // To write into a file HDF5 appends to it, nearly always, and to pack it anew gives it another length: one that has
    // its length is damaged, and the generation before it is the one to go on from. So is one that is cut off, which
    // HDF5 does not open. To look at it, the samples are enough.
    const bool resized = dynamic_cast<const ResizedRunFile*>(&damage) != nullptr;
    if ((changed == Changed::refused && !resized) || !impl_->is_sound_without_block()) throw;
    if (changed == Changed::refused) {
      throw ChangedRunFile(path,
                           "another program has changed it since (h5repack, h5py or the like): it can be scored "
                           "and exported, but not resumed; take an earlier copy of it, or make it again");
    }
    impl_->change =
        "another program has changed it since it was written, so that its digests do not apply; the samples are those "
        "that /checksum describes, but config, history and state may be anything";
    return;
  }
  std::vector<std::string> names;
  for (const SlicePlace& place : block->slices) names.push_back(place.name);
  impl_->read_all(&names);
  impl_->check_places(*block);
  impl_->close_hdf5();
}

RunFileReader::~RunFileReader() = default;
RunFileReader::RunFileReader(RunFileReader&&) noexcept = default;

const std::string& RunFileReader::path() const { return impl_->path; }

const RunFileContent& RunFileReader::content() const { return impl_->content; }
const std::string& RunFileReader::change() const { return impl_->change; }

int RunFileReader::dataset(const std::string& name) const {
  const auto found = std::ranges::find(impl_->content.datasets, name, &SliceDataset::name);
  return found == impl_->content.datasets.end() ? -1 : static_cast<int>(found - impl_->content.datasets.begin());
}

void RunFileReader::read_slice(int dataset, SliceIndex slice, std::span<std::byte> bytes) const {
  const hdf5::Quiet quiet;
  NOISELOOM_CHECK(dataset >= 0 && narrow<std::size_t>(dataset) < impl_->content.datasets.size());
  impl_->read_slice(narrow<std::size_t>(dataset), slice, bytes);
}

namespace {

std::optional<Beginning> beginning_at(const std::string& path) {
  try {
    require_file(path);
    const OpenedFile file(posix_file_ops(), path);
    return beginning_of(posix_file_ops(), file.fd());
  } catch (const EnvironmentError&) {
    return std::nullopt;
  } catch (const UserError&) {
    return Beginning::other;
  }
}

}  // namespace

bool looks_like_run_file(const std::string& path) { return beginning_at(path) == Beginning::run_file; }

bool may_be_run_file(const std::string& path) { return beginning_at(path) != Beginning::other; }

}  // namespace noiseloom
