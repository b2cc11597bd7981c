// Bare numbers: .npy, and .raw with a description beside it.
#include <fmt/format.h>

#include <bit>
#include <filesystem>

#include "image/containers/container_writers.h"
#include "noiseloom/core/json.h"
#include "noiseloom/files/npy.h"

namespace noiseloom {
namespace {

static_assert(std::endian::native == std::endian::little, "the files are little-endian");

// All slices: [slice axes..., y, x, channel]; some of them: [slice, y, x, channel].
std::vector<std::int64_t> array_shape(const ContainerJob& job) {
  std::vector<std::int64_t> shape = job.extents.file_dimensions();
  if (!job.holds_all_slices()) shape = {job.num_slices, job.extents.height(), job.extents.width()};
  shape.push_back(job.slice.channels);
  return shape;
}

class NpyWriter : public ContainerWriter {
 public:
  explicit NpyWriter(OutputFiles& files) : files_(files) {}

  void begin(const std::string& target, const ContainerJob& job) override {
    stream_ = files_.open(target);
    stream_->append(npy_float32_header(array_shape(job)));
  }
  void slice(SliceIndex, std::span<const std::byte> bytes) override { stream_->append(bytes); }
  void end() override { stream_->close(); }

 private:
  OutputFiles& files_;
  std::unique_ptr<OutputStream> stream_;
};

const char* type_name(PixelType type) {
  switch (type) {
    case PixelType::uint8:
      return "uint8";
    case PixelType::uint16:
      return "uint16";
    case PixelType::uint32:
      return "uint32";
    case PixelType::float16:
      return "float16";
    case PixelType::float32:
      return "float32";
  }
  return "";
}

// Where the numbers come from. What a config says of all channels there is none of in a pack.
std::string members_of_facts(const ContainerJob& job) {
  std::string members;
  if (!job.config.empty()) members = fmt::format("  \"config\": {}", json_string(job.config));
  for (const auto& [key, value] : job.facts)
    if (job.config.empty() || (key != "samples" && key != "config"))
      members += fmt::format("{}  {}: {}", members.empty() ? "" : ",\n", json_string(key), json_string(value));
  return members;
}

// What a program must know to read the numbers of `target`, as JSON.
std::string sidecar(const std::string& target, const ContainerJob& job) {
  const Extents& extents = job.extents;
  std::string axes;
  if (!job.holds_all_slices()) {
    axes = "\"slice\", ";
  } else {
    for (int axis = extents.num_axes() - 1; axis >= 2; --axis) axes += json_string(extents.name(axis)) + ", ";
  }
  std::string unfinished;
  if (!job.unfinished.empty()) unfinished = fmt::format("  \"unfinished\": {},\n", json_string(job.unfinished));
  const ValueRange range = job.range.value_or(ValueRange{});
  return fmt::format(
      "{{\n"
      "  \"file\": {},\n"
      "  \"type\": \"{}\",\n"
      "  \"byte_order\": \"little\",\n"
      "  \"shape\": [{}],\n"
      "  \"axes\": [{}\"y\", \"x\", \"channel\"],\n"
      "  \"first_slice\": {},\n"
      "  \"samples\": {},\n"
      "  \"value\": {},\n"
      "  \"encoded\": {},\n"
      "  \"range\": [{}, {}],\n"
      "{}{}\n"
      "}}\n",
      json_string(std::filesystem::path(target).filename().string()), type_name(job.slice.type),
      fmt::join(array_shape(job), ", "), axes, job.first_slice.value(), json_string(job.samples),
      json_string(job.decoding), job.range ? "true" : "false", json_number(range.lo), json_number(range.hi), unfinished,
      members_of_facts(job));
}

class RawWriter : public ContainerWriter {
 public:
  explicit RawWriter(OutputFiles& files) : files_(files) {}

  void begin(const std::string& target, const ContainerJob& job) override {
    files_.write(std::filesystem::path(target).replace_extension(".json").string(), sidecar(target, job));
    stream_ = files_.open(target);
  }
  void slice(SliceIndex, std::span<const std::byte> bytes) override { stream_->append(bytes); }
  void end() override { stream_->close(); }

 private:
  OutputFiles& files_;
  std::unique_ptr<OutputStream> stream_;
};

}  // namespace

std::unique_ptr<ContainerWriter> make_npy_writer(OutputFiles& files) { return std::make_unique<NpyWriter>(files); }
std::unique_ptr<ContainerWriter> make_raw_writer(OutputFiles& files) { return std::make_unique<RawWriter>(files); }

}  // namespace noiseloom
