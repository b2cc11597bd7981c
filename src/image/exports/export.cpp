#include "noiseloom/image/export.h"

#include "image/facts/provenance.h"
#include "image/facts/stored_number.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "noiseloom/config/config.h"
#include "noiseloom/files/generations.h"
#include "noiseloom/files/order_codec.h"
#include "noiseloom/files/output_files.h"
#include "noiseloom/files/pixel_order.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {
namespace {

// Slices of a run file as the pixels of an output, or as the places of its pixels in the sequence.
class SliceEncoder {
 public:
  // `order`: of a point set that is exported, else null. `below_one`: the samples are numbers of [0, 1).
  SliceEncoder(const RunFileReader& reader, const ExportPlan& plan, const PixelOrder* order, bool below_one)
      : reader_(reader), plan_(plan), order_(order) {
    const RunFileContent& content = reader.content();
    samples_ = reader.dataset("/samples");
    if (order_ == nullptr)
      channels_ = static_cast<std::size_t>(content.datasets[static_cast<std::size_t>(samples_)].channels);
    cells_ = static_cast<std::size_t>(content.extents.cells_per_slice());
    below_one_ = below_one;
    values_.resize(cells_ * channels_);
    if (std::any_of(plan.outputs.begin(), plan.outputs.end(), [](const ExportOutput& o) { return o.has_density(); })) {
      find_largest_density();
    }
  }

  double largest_density() const { return largest_density_; }

  // Valid until the next call.
  std::span<const std::byte> slice(SliceIndex slice, const ExportOutput& output) {
    return output.container->content == ContainerContent::places ? read_places(slice) : pixels(slice, output);
  }

  // How many points of the plan lie in its slices.
  std::int64_t count_points() {
    std::int64_t count = 0;
    for (const SliceIndex s : plan_.slices()) {
      read_places(s);
      count += std::count_if(places_.begin(), places_.end(), [&](OrderPlace place) { return is_point(place); });
    }
    return count;
  }

 private:
  bool is_point(OrderPlace place) const { return place < OrderPlace(*plan_.num_points); }

  std::span<const std::byte> read_places(SliceIndex slice) {
    places_.resize(cells_);
    order_->read_slice(slice, places_);
    return std::as_bytes(std::span(places_));
  }
  // 1 where a pixel is a point and 0 elsewhere.
  void read_points(SliceIndex slice) {
    read_places(slice);
    std::transform(places_.begin(), places_.end(), values_.begin(),
                   [&](OrderPlace place) { return is_point(place) ? 1.0F : 0.0F; });
  }
  void read_samples(const TextureRead::Place& place) {
    reader_.read_slice(samples_, place.slice, std::as_writable_bytes(std::span(values_)));
    shift(place, channels_, values_);
  }
  void read_density(const TextureRead::Place& place) {
    density_.resize(cells_);
    reader_.read_slice(reader_.dataset("/pdf"), place.slice, std::as_writable_bytes(std::span(density_)));
    shift(place, 1, density_);
  }
  // What is written as slice `slice`.
  TextureRead::Place place_of(SliceIndex slice) const {
    if (!plan_.reads) return {.slice = slice};
    return plan_.reads->place(slice.value() / plan_.reads->values, slice.value() % plan_.reads->values);
  }
  // Pixel (x, y) becomes what pixel (x + dx, y + dy) is, around the edges.
  void shift(const TextureRead::Place& place, std::size_t channels, std::vector<float>& numbers) const {
    const auto row = static_cast<std::ptrdiff_t>(static_cast<std::size_t>(plan_.extents.width()) * channels);
    for (auto begin = numbers.begin(); begin != numbers.end() && place.dx != 0; begin += row) {
      std::rotate(begin, begin + place.dx * static_cast<std::ptrdiff_t>(channels), begin + row);
    }
    std::rotate(numbers.begin(), numbers.begin() + place.dy * row, numbers.end());
  }
  void find_largest_density() {
    for (const SliceIndex s : reader_.content().extents.slices()) {
      read_density({.slice = s});
      largest_density_ =
          std::max(largest_density_, static_cast<double>(*std::max_element(density_.begin(), density_.end())));
    }
  }

  std::span<const std::byte> pixels(SliceIndex slice, const ExportOutput& output) {
    if (order_ != nullptr)
      read_points(slice);
    else
      read_samples(place_of(slice));
    if (output.has_density()) read_density(place_of(slice));
    const std::vector<int>& source = output.pixel.source;
    bytes_.resize(cells_ * source.size() * bytes_per_number(output.type));
    const std::size_t bytes = bytes_per_number(output.type);
    const bool clamped = output.container->numbers == StoredNumbers::unit;
    for (std::size_t cell = 0; cell < cells_; ++cell)
      for (std::size_t c = 0; c < source.size(); ++c) {
        const double number = number_of(cell, source[c]);
        store_number(clamped ? std::clamp(number, 0.0, 1.0) : number, output.type, below_one_,
                     bytes_.data() + (cell * source.size() + c) * bytes);
      }
    return bytes_;
  }

  // What a channel of the pixel holds, where integers stand for 0 to 1.
  double number_of(std::size_t cell, int source) const {
    if (source == zero_channel) return 0;
    if (source == opaque_channel) return 1;
    if (source == density_channel)
      return largest_density_ > 0 ? static_cast<double>(density_[cell]) / largest_density_ : 0;
    const double value = static_cast<double>(values_[cell * channels_ + static_cast<std::size_t>(source)]);
    return plan_.range ? to_unit(*plan_.range, value) : value;
  }

  const RunFileReader& reader_;
  const ExportPlan& plan_;
  const PixelOrder* order_;
  int samples_ = 0;
  bool below_one_ = false;  // the range of the space is 0 to 1
  std::size_t channels_ = 1;
  std::size_t cells_ = 0;
  double largest_density_ = 0;
  std::vector<float> values_;
  std::vector<float> density_;
  std::vector<OrderPlace> places_;
  std::vector<std::byte> bytes_;
};

// How to get the values back, for people and programs.
std::string decoding(const ExportPlan& plan, PixelType type) {
  if (plan.num_points)
    return fmt::format("0, or the largest number where a pixel is one of the {} points", *plan.num_points);
  const std::string stored = type == PixelType::uint8    ? "(b + 0.5) / 256"
                             : type == PixelType::uint16 ? "(b + 0.5) / 65536"
                             : type == PixelType::uint32 ? "(b + 0.5) / 4294967296"
                                                         : "number stored";
  if (!plan.range || *plan.range == ValueRange{}) return stored;
  return fmt::format("{} + {} * {}", plan.range->lo, plan.range->hi - plan.range->lo, stored);
}

std::string slices_text(const ContainerJob& job) {
  if (job.layout == ExportLayout::slices) return fmt::format("slice {}", job.first_slice.value());
  return fmt::format("slices {} to {}", job.first_slice.value(), job.slices().past_last().value() - 1);
}

std::string description(const ExportPlan& plan, const ExportOutput& output, const ContainerJob& job,
                        double largest_density) {
  std::string text;
  if (plan.num_points) {
    text = fmt::format("point set, {} of {}; white: the {} pixels that come first of {}", slices_text(job),
                       job.extents.to_string(), *plan.num_points, job.extents.num_cells());
  } else {
    const bool of_density = output.has_density() && !plan.with_density;
    text =
        fmt::format("{}, {} of {}; samples {}; value = {}", of_density ? "density of sampling noise" : "sampling noise",
                    slices_text(job), job.extents.to_string(), job.samples,
                    of_density ? fmt::format("density / {}", largest_density) : job.decoding);
    if (plan.reads) {
      text += fmt::format("; the slices are frames as a shader reads them, {} {} each", plan.reads->values,
                          plan.reads->values == 1 ? "value" : "values");
    }
    if (plan.with_density) text += fmt::format("; alpha = density / {}", largest_density);
  }
  return job.unfinished.empty() ? text : text + "; " + job.unfinished;
}

// All files of one output. `job` holds what is the same for all of an export.
void write_output(OutputFiles& files, const ExportPlan& plan, const ExportOutput& output, ContainerJob job,
                  SliceEncoder& encoder) {
  const std::unique_ptr<ContainerWriter> writer = output.container->make(files);
  output.describe(job, plan.num_slices());
  job.decoding = decoding(plan, output.type);
  job.holds_samples = !plan.num_points && !plan.reads && (!output.has_density() || plan.with_density);
  for (std::size_t f = 0; f < output.targets.size(); ++f) {
    job.first_slice = SliceIndex(plan.begin + narrow<std::int32_t>(f));
    job.description = description(plan, output, job, encoder.largest_density());
    writer->begin(output.targets[f], job);
    for (const SliceIndex s : job.slices()) writer->slice(s, encoder.slice(s, output));
    writer->end();
  }
}

std::string points_text(const ExportPlan& plan, const Extents& extents, SliceEncoder& encoder) {
  std::string text = fmt::format("{} points: the earliest of {} pixels", *plan.num_points, extents.num_cells());
  if (plan.end - plan.begin != extents.num_slices())
    text += fmt::format("; {} of them in slices {} to {}", encoder.count_points(), plan.begin, plan.end - 1);
  return text;
}

}  // namespace

bool ExportOutput::has_density() const {
  return std::find(pixel.source.begin(), pixel.source.end(), density_channel) != pixel.source.end();
}

void ExportOutput::describe(ContainerJob& job, std::int32_t num_slices) const {
  job.layout = layout;
  job.columns = columns;
  job.num_slices = layout == ExportLayout::slices ? 1 : num_slices;
  job.slice = {narrow<int>(job.extents.width()),
               narrow<int>(job.extents.height()),
               static_cast<int>(pixel.source.size()),
               type,
               pixel.names,
               pixel.alpha};
}

std::string unfinished_run(const RunFileContent& content, const RunConfig& config) {
  const auto finished = content.state.find("finished");
  if (finished == content.state.end() || finished->second != Attribute(std::string())) return "";
  for (const auto& [column, values] : content.history) {
    if (column != "iterations" || values.empty()) continue;
    const std::int64_t wanted = config.optimizer.stop.iterations;
    return fmt::format("not finished: {} {}iterations done", values.back(),
                       wanted > 0 ? fmt::format("of {} ", wanted) : "");
  }
  return "not finished";
}

ExportResult export_run_file(const std::string& path, const ExportOptions& options, FileOps& ops) {
  const RunFileReader reader = open_to_look_at(path);
  const RunFileContent& content = reader.content();
  if (options.threshold.empty() && reader.dataset("/samples") < 0) throw UserError(path, "holds no /samples");
  const RunConfig config =
      parse_config(content.config, path + ": /config", parent_directory(path), {}, MissingFiles::accepted);
  require_finished_order(content, path);
  const ExportPlan plan = plan_export(path, content, config.problem, options);
  std::optional<PixelOrder> order;
  if (plan.num_points) order.emplace(reader, path);
  OutputFiles files(ops, options.overwrite);
  std::vector<std::string> targets;
  for (const ExportOutput& output : plan.outputs)
    targets.insert(targets.end(), output.targets.begin(), output.targets.end());
  files.check(targets);

  ExportResult result;
  result.change = reader.change();
  result.unfinished = unfinished_run(content, config);
  ContainerJob job;
  job.source = path;
  job.extents = plan.extents;
  job.range = plan.range;
  job.samples = describe_samples(config.problem.samples);
  job.directions = reader.dataset("/samples") >= 0 && !plan.num_points && are_unit_vectors(config.problem.samples);
  job.config = content.config;
  job.facts = facts_of(content, config);
  job.unfinished = result.unfinished;
  job.num_points = plan.num_points;
  SliceEncoder encoder(reader, plan, order ? &*order : nullptr, natural_range(config.problem.samples) == ValueRange{});
  for (const ExportOutput& output : plan.outputs) {
    const std::size_t before = files.targets().size();
    write_output(files, plan, output, job, encoder);
    const std::vector<std::string> written = files.targets();
    std::vector<std::string>& list =
        output.container->content == ContainerContent::places ? result.tables : result.files;
    list.insert(list.end(), written.begin() + static_cast<std::ptrdiff_t>(before), written.end());
  }
  if (order) result.points = points_text(plan, content.extents, encoder);
  files.commit();
  return result;
}

}  // namespace noiseloom
