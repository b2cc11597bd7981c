#include "noiseloom/image/export.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <filesystem>

#include "image/export_points.h"
#include "noiseloom/config/config.h"
#include "noiseloom/core/json.h"
#include "noiseloom/files/npy.h"
#include "noiseloom/files/order_codec.h"
#include "noiseloom/files/output_files.h"
#include "noiseloom/files/pixel_order.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {
namespace {

// Slices of a run file as pixels of the plan; with `order`, 1 where a pixel is a point of the plan and 0 elsewhere.
class SliceEncoder {
 public:
  SliceEncoder(const RunFileReader& reader, const ExportPlan& plan, const PixelOrder* order)
      : reader_(reader), plan_(plan), order_(order) {
    const RunFileContent& content = reader.content();
    samples_ = reader.dataset("/samples");
    if (order_ == nullptr)
      channels_ = static_cast<std::size_t>(content.datasets[static_cast<std::size_t>(samples_)].channels);
    cells_ = static_cast<std::size_t>(content.extents.cells_per_slice());
    values_.resize(cells_ * channels_);
    bytes_.resize(cells_ * plan.pixel.source.size() * bytes_per_number(plan.type));
    if (plan.with_density) find_largest_density();
  }

  std::size_t num_bytes() const { return bytes_.size(); }
  double largest_density() const { return largest_density_; }

  // Valid until the next call.
  std::span<const std::byte> operator()(SliceIndex slice) {
    if (order_ != nullptr)
      read_points(slice);
    else
      reader_.read_slice(samples_, slice, std::as_writable_bytes(std::span(values_)));
    if (plan_.with_density) read_density(slice);
    const std::size_t pixel_channels = plan_.pixel.source.size();
    for (std::size_t cell = 0; cell < cells_; ++cell)
      for (std::size_t c = 0; c < pixel_channels; ++c) store(cell, c, cell * pixel_channels + c);
    return bytes_;
  }

 private:
  void read_points(SliceIndex slice) {
    ranks_.resize(cells_);
    order_->read_slice(slice, ranks_);
    const auto count = static_cast<std::uint64_t>(*plan_.num_points);
    std::transform(ranks_.begin(), ranks_.end(), values_.begin(),
                   [&](std::uint64_t rank) { return rank < count ? 1.0F : 0.0F; });
  }
  void read_density(SliceIndex slice) {
    density_.resize(cells_);
    reader_.read_slice(reader_.dataset("/pdf"), slice, std::as_writable_bytes(std::span(density_)));
  }
  void find_largest_density() {
    for (SliceIndex s = 0; s < reader_.content().extents.num_slices(); ++s) {
      read_density(s);
      largest_density_ =
          std::max(largest_density_, static_cast<double>(*std::max_element(density_.begin(), density_.end())));
    }
  }

  void store(std::size_t cell, std::size_t channel, std::size_t index) {
    const int source = plan_.pixel.source[channel];
    double number = 0;
    if (source == density_channel)
      number = largest_density_ > 0 ? static_cast<double>(density_[cell]) / largest_density_ : 0;
    else if (source != zero_channel) {
      const double value = static_cast<double>(values_[cell * channels_ + static_cast<std::size_t>(source)]);
      number = plan_.range ? to_unit(*plan_.range, value) : value;
    }
    switch (plan_.type) {
      case PixelType::uint8:
        bytes_[index] = std::byte(source == zero_channel ? 0 : quantise(number, 8));
        break;
      case PixelType::uint16: {
        const std::uint16_t b = source == zero_channel ? std::uint16_t{0} : quantise(number, 16);
        std::memcpy(bytes_.data() + 2 * index, &b, sizeof b);
        break;
      }
      case PixelType::float32: {
        if (plan_.image == ImageFormat::hdr) number = std::clamp(number, 0.0, 1.0);
        const float f = static_cast<float>(number);
        std::memcpy(bytes_.data() + 4 * index, &f, sizeof f);
        break;
      }
    }
  }

  const RunFileReader& reader_;
  const ExportPlan& plan_;
  const PixelOrder* order_;
  int samples_ = 0;
  std::size_t channels_ = 1;
  std::size_t cells_ = 0;
  double largest_density_ = 0;
  std::vector<float> values_;
  std::vector<float> density_;
  std::vector<std::uint64_t> ranks_;
  std::vector<std::byte> bytes_;
};

// How to get the values back, for people and programs.
std::string decoding(const ExportPlan& plan) {
  if (plan.num_points)
    return fmt::format("0, or the largest number where a pixel is one of the {} points", *plan.num_points);
  const std::string stored = plan.type == PixelType::uint8    ? "(b + 0.5) / 256"
                             : plan.type == PixelType::uint16 ? "(b + 0.5) / 65536"
                                                              : "number stored";
  if (!plan.range || *plan.range == ValueRange{}) return stored;
  return fmt::format("{} + {} * {}", plan.range->lo, plan.range->hi - plan.range->lo, stored);
}

std::string description(const ExportPlan& plan, const ProblemSpec& problem, double largest_density,
                        const std::string& which) {
  if (plan.num_points)
    return fmt::format("point set, {} of {}; white: the {} pixels that come first of {}", which,
                       problem.extents.to_string(), *plan.num_points, problem.extents.num_cells());
  std::string text = fmt::format("sampling noise, {} of {}; samples {}; value = {}", which, problem.extents.to_string(),
                                 sample_space_name(problem.samples), decoding(plan));
  if (plan.with_density) text += fmt::format("; alpha = density / {}", largest_density);
  return text;
}

void write_images(OutputFiles& files, const ExportPlan& plan, const ProblemSpec& problem, SliceEncoder& encoder) {
  const Extents& extents = problem.extents;
  ImageJob job;
  job.format = *plan.image;
  job.block = {narrow<int>(extents.width()),
               narrow<int>(extents.height()),
               static_cast<int>(plan.pixel.source.size()),
               plan.type,
               plan.pixel.names,
               plan.pixel.alpha};
  if (plan.layout == ExportLayout::slices) {
    for (SliceIndex s = plan.begin; s < plan.end; ++s) {
      job.description = description(plan, problem, encoder.largest_density(), fmt::format("slice {}", s));
      const std::string target = plan.targets[static_cast<std::size_t>(s - plan.begin)];
      write_image(files.add(target), job, [&](int) { return encoder(s); });
    }
    return;
  }
  job.num_blocks = plan.end - plan.begin;
  job.stacking = plan.layout == ExportLayout::parts ? Stacking::parts : Stacking::down;
  job.description =
      description(plan, problem, encoder.largest_density(), fmt::format("slices {} to {}", plan.begin, plan.end - 1));
  for (SliceIndex s = plan.begin; s < plan.end; ++s) job.part_names.push_back(fmt::format("slice{}", s));
  write_image(files.add(plan.targets.front()), job, [&](int block) { return encoder(plan.begin + block); });
}

std::vector<std::string> all_targets(const ExportPlan& plan) {
  std::vector<std::string> targets = plan.targets;
  for (const std::string& target : {plan.points_csv, plan.points_npy})
    if (!target.empty()) targets.push_back(target);
  return targets;
}

// All slices: [slice axes..., y, x, channel]; some of them: [slice, y, x, channel].
std::vector<std::int64_t> array_shape(const ExportPlan& plan, const Extents& extents) {
  std::vector<std::int64_t> shape = extents.file_dimensions();
  if (plan.end - plan.begin != extents.num_slices()) shape = {plan.end - plan.begin, extents.height(), extents.width()};
  shape.push_back(static_cast<std::int64_t>(plan.pixel.source.size()));
  return shape;
}

std::string joined(const std::vector<std::int64_t>& numbers) {
  std::string text;
  for (const std::int64_t n : numbers) text += fmt::format("{}{}", text.empty() ? "" : ", ", n);
  return text;
}

std::string sidecar(const ExportPlan& plan, const ProblemSpec& problem, const std::string& config) {
  const Extents& extents = problem.extents;
  const bool whole = plan.end - plan.begin == extents.num_slices();
  std::string axes;
  for (int axis = extents.num_axes() - 1; axis >= 2 && whole; --axis) axes += json_string(extents.name(axis)) + ", ";
  if (!whole) axes = "\"slice\", ";
  const std::string type = plan.type == PixelType::uint8    ? "uint8"
                           : plan.type == PixelType::uint16 ? "uint16"
                                                            : "float32";
  const ValueRange range = plan.range.value_or(ValueRange{});
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
      "  \"config\": {}\n"
      "}}\n",
      json_string(std::filesystem::path(plan.targets.front()).filename().string()), type,
      joined(array_shape(plan, extents)), axes, plan.begin, json_string(sample_space_name(problem.samples)),
      json_string(decoding(plan)), plan.range ? "true" : "false", json_number(range.lo), json_number(range.hi),
      json_string(config));
}

void write_array(OutputFiles& files, const ExportPlan& plan, const ProblemSpec& problem, const std::string& config,
                 SliceEncoder& encoder) {
  const std::string& target = plan.targets.front();
  std::string header;
  if (plan.format == "npy")
    header = npy_float32_header(array_shape(plan, problem.extents));
  else
    files.write(std::filesystem::path(target).replace_extension(".json").string(), sidecar(plan, problem, config));
  files.write_pieces(target, [&](const OutputFiles::Append& append) {
    append(std::as_bytes(std::span(header.data(), header.size())));
    for (SliceIndex s = plan.begin; s < plan.end; ++s) append(encoder(s));
  });
}

}  // namespace

ExportResult export_run_file(const std::string& path, const ExportOptions& options, FileOps& ops) {
  const RunFileReader reader(path);
  const RunFileContent& content = reader.content();
  if (options.threshold.empty() && reader.dataset("/samples") < 0) throw UserError(path, "holds no /samples");
  const RunConfig config =
      parse_config(content.config, path + ": /config", parent_directory(path), {}, MissingFiles::accepted);
  require_finished_order(content, path);
  const ExportPlan plan = plan_export(path, content, config.problem, options);
  std::optional<PixelOrder> order;
  if (plan.num_points) order.emplace(reader, path);
  OutputFiles files(ops, options.overwrite);
  files.check(all_targets(plan));
  SliceEncoder encoder(reader, plan, order ? &*order : nullptr);
  if (plan.image)
    write_images(files, plan, config.problem, encoder);
  else
    write_array(files, plan, config.problem, content.config, encoder);
  ExportResult result;
  result.files = files.targets();
  if (order) {
    result.points = write_points(files, plan, content.extents, *order);
    for (const std::string& target : files.targets())
      if (target == plan.points_csv || target == plan.points_npy) result.tables.push_back(target);
  }
  files.commit();
  return result;
}

}  // namespace noiseloom
