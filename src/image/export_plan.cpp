#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>

#include "noiseloom/core/decimal.h"
#include "noiseloom/files/pixel_order.h"
#include "noiseloom/image/export.h"
#include "noiseloom/image/naming.h"
#include "noiseloom/image/sequence.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {
namespace {

namespace fs = std::filesystem;

// Where the files go: a file (or pattern of files) in a folder, or a folder alone.
struct Output {
  fs::path folder;
  std::string file;  // "": a folder was given
};

Output split_output(const std::string& output) {
  const fs::path path(output);
  if (output.ends_with("/") || fs::is_directory(path) || (path.extension().empty() && !is_sequence_pattern(output)))
    return {path, ""};
  return {path.parent_path(), path.filename().string()};
}

template <class Accept>
std::string names_of(Accept accept) {
  std::vector<std::string> names;
  for (const Container& container : containers())
    if (container.content == ContainerContent::pixels && accept(container)) names.push_back(container.name);
  return fmt::format("{}", fmt::join(names, ", "));
}

std::vector<std::string> all_names() {
  std::vector<std::string> names;
  for (const Container& container : containers()) names.push_back(container.name);
  return names;
}

class Planner {
 public:
  Planner(const std::string& name, const RunFileContent& content, const ProblemSpec& problem,
          const ExportOptions& options)
      : name_(name), content_(content), problem_(problem), options_(options), output_(split_output(options.output)) {}

  ExportPlan plan() {
    choose_container();
    if (container_ == nullptr) throw_if_any(faults_);
    main_.container = container_;
    choose_type();
    choose_layout();
    choose_frames();
    choose_slices();
    choose_points();
    choose_naming();
    if (container_->content == ContainerContent::pixels) {
      choose_pixel();
      choose_range();
    }
    throw_if_any(faults_);
    choose_targets();
    throw_if_any(faults_);
    return std::move(plan_);
  }

 private:
  void fault(const std::string& text) { faults_.push_back({"command line", text}); }
  template <class Parse>
  auto parsed(Parse parse) -> decltype(parse()) {
    try {
      return parse();
    } catch (const UserError& error) {
      faults_.insert(faults_.end(), error.faults().begin(), error.faults().end());
      return {};
    }
  }
  bool points_wanted() const { return !options_.threshold.empty(); }
  bool density_wanted() const { return options_.density == "alpha" || options_.density == "separate"; }

  void choose_container() {
    if (options_.output == "-") {
      fault("-o -: an export is one or more files, which cannot go to standard output; give a file or a folder");
      return;
    }
    const std::string ending = fs::path(output_.file).extension().string();
    const Container* const by_ending = ending.empty() ? nullptr : container_of_file(output_.file);
    if (!ending.empty() && by_ending == nullptr) {
      fault(fmt::format("-o {}: \"{}\" is no ending of a container that is written; accepted: {} (a folder ends in /)",
                        options_.output, ending, container_names()));
      return;
    }
    if (options_.format.empty()) {
      container_ = by_ending != nullptr ? by_ending : &containers().front();
    } else {
      container_ = find_container(options_.format, ContainerContent::pixels);
      if (container_ == nullptr) container_ = find_container(options_.format, ContainerContent::places);
      if (container_ == nullptr) {
        const std::string nearest = nearest_word(options_.format, all_names());
        fault(fmt::format("--format {}: not written{}; accepted: {}", options_.format,
                          nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest), container_names()));
      } else if (by_ending != nullptr && by_ending != container_) {
        fault(fmt::format("--format {}, but -o {} ends in {}", container_->name, options_.output, ending));
      }
    }
    if (container_ != nullptr && container_->content == ContainerContent::places && !points_wanted())
      fault(
          fmt::format("{} holds the coordinates of a point set: give its density with --threshold; accepted for the "
                      "values of a texture: {}",
                      container_->name, names_of([](const Container&) { return true; })));
  }

  void choose_type() {
    if (container_->types.empty()) {
      if (!options_.depth.empty())
        fault(fmt::format("--depth {}: {} holds no pixels", options_.depth, container_->name));
      return;
    }
    main_.type = container_->types.front();
    if (options_.depth.empty()) return;
    std::vector<std::string> accepted;
    for (const PixelType type : container_->types) {
      accepted.push_back(depth_name(type));
      if (accepted.back() != options_.depth) continue;
      main_.type = type;
      return;
    }
    fault(fmt::format("--depth {0}: {1} does not hold it; accepted for {1}: {2}", options_.depth, container_->name,
                      fmt::join(accepted, ", ")));
  }

  void choose_layout() {
    main_.layout = container_->layouts.front();
    if (options_.layout.empty()) return;
    std::vector<std::string> accepted;
    for (const ExportLayout layout : container_->layouts) {
      accepted.push_back(to_string(layout));
      if (accepted.back() != options_.layout) continue;
      main_.layout = layout;
      return;
    }
    fault(accepted.size() == 1 ? fmt::format("--layout {}: {} always holds the whole {}", options_.layout,
                                             container_->name, accepted.front())
                               : fmt::format("--layout {}: accepted for {}: {}", options_.layout, container_->name,
                                             fmt::join(accepted, ", ")));
  }

  // A count on the command line, 1 to `most`.
  SliceIndex count_of(const std::string& option, const std::string& text, SliceIndex most) {
    if (text.empty()) return 1;
    SliceIndex count = 0;
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), count);
    if (error == std::errc{} && stop == text.data() + text.size() && count >= 1 && count <= most) return count;
    fault(fmt::format("{} {}: must be from 1 to {}", option, text, most));
    return 1;
  }

  void choose_frames() {
    plan_.extents = content_.extents;
    if (options_.frames.empty() && options_.values.empty() && options_.read.empty()) return;
    constexpr SliceIndex most_frames = 1'000'000;
    constexpr SliceIndex most_values = 1024;
    const Extents& texture = content_.extents;
    const SliceIndex values = count_of("--values", options_.values, most_values);
    const SliceIndex frames =
        options_.frames.empty() ? texture.num_slices() : count_of("--frames", options_.frames, most_frames);
    TextureRead reads = {texture.width(), texture.height(), texture.num_slices(), values};
    if (options_.read == "slices") {
      reads.from = ValuesFrom::slices;
    } else if (!options_.read.empty() && options_.read != "offsets") {
      fault(fmt::format("--read {}: accepted: offsets, slices", options_.read));
    }
    if (points_wanted()) fault("--frames, --values: a point set (--threshold) has slices alone");
    if (texture.num_axes() > 3) {
      fault(fmt::format("--frames, --values: a shader's frames run along one slice axis; the texture has {}",
                        texture.num_axes() - 2));
    }
    if (std::max(texture.width(), texture.height()) > 65536) {
      fault("--frames, --values: for textures of at most 65536 pixels a side");
    }
    plan_.reads = reads;
    std::vector<std::int64_t> sizes = {texture.width(), texture.height()};
    std::vector<std::string> names = {"x", "y"};
    if (values > 1) {  // the last slice axis varies slowest
      sizes.push_back(values);
      names.emplace_back("value");
    }
    sizes.push_back(frames);
    names.emplace_back("frame");
    plan_.extents = Extents(sizes, names);
  }

  void choose_slices() {
    const SliceIndex count = plan_.extents.num_slices();
    plan_.begin = 0;
    plan_.end = count;
    if (options_.slices.empty()) return;
    const std::string& text = options_.slices;
    const std::size_t colon = text.find(':');
    const auto number = [&](std::size_t begin, std::size_t end, SliceIndex& value) {
      if (begin == end) return true;  // left out: from the start, to the end
      const auto [stop, error] = std::from_chars(text.data() + begin, text.data() + end, value);
      return error == std::errc{} && stop == text.data() + end;
    };
    const bool read =
        colon != std::string::npos && number(0, colon, plan_.begin) && number(colon + 1, text.size(), plan_.end);
    if (!read || plan_.begin < 0 || plan_.end > count || plan_.begin >= plan_.end)
      fault(fmt::format("--slices {}: must be A:B with 0 <= A < B <= {} (slices A, ..., B - 1)", text, count));
  }

  // A part of a sequence holds points of the whole: the count does not depend on --slices.
  void choose_points() {
    if (!points_wanted()) return;
    plan_.num_points = 1;
    if (const std::string why = why_order_cannot_be_read(content_); !why.empty()) faults_.push_back({name_, why});
    if (density_wanted()) fault("--pdf: a point set (--threshold) has no density");
    if (!options_.range.empty()) fault("--range: a point set (--threshold) holds black and white alone");
    const std::optional<DecimalFraction> fraction =
        parsed([&] { return std::optional(parse_fraction("--threshold", options_.threshold)); });
    if (!fraction) return;
    const std::int64_t num_pixels = content_.extents.num_cells();
    plan_.num_points = fraction->floor_of_times(num_pixels);
    density_ = fraction->text();
    if (*plan_.num_points == 0)
      fault(fmt::format("--threshold {}: that is no point of {} pixels; the least that is one: {:.3g}",
                        options_.threshold, num_pixels, 1 / static_cast<double>(num_pixels)));
  }

  void choose_naming() {
    pattern_in_output_ = !output_.file.empty() && is_sequence_pattern(output_.file);
    if (pattern_in_output_ && !options_.naming.empty())
      fault(fmt::format("-o {} is a pattern already; leave --naming out", options_.output));
    const std::string text = pattern_in_output_ ? output_.file : options_.naming.empty() ? "plain" : options_.naming;
    naming_ = parsed([&] { return parse_naming(text); });
    for (const std::string& part : {output_.folder.string(), pattern_in_output_ ? std::string() : output_.file})
      if (const std::string why = why_no_file_name(part); !why.empty())
        fault(fmt::format("-o {}: {}", options_.output, why));
    if (output_.file.empty() || pattern_in_output_) return;
    if (naming_.scheme != NamingScheme::plain)
      fault(fmt::format("--naming {} names the files itself: give a folder, not -o {}", options_.naming,
                        options_.output));
  }

  int channels() const {
    if (plan_.num_points) return 1;
    for (const SliceDataset& dataset : content_.datasets)
      if (dataset.name == "/samples") return dataset.channels;
    return 0;
  }

  void choose_pixel() {
    if (!options_.density.empty() && options_.density != "none" && !density_wanted()) {
      fault(fmt::format("--pdf {}: accepted: alpha, separate, none", options_.density));
    }
    plan_.with_density = options_.density == "alpha" && !plan_.num_points;
    const bool has_density = std::any_of(content_.datasets.begin(), content_.datasets.end(),
                                         [](const SliceDataset& dataset) { return dataset.name == "/pdf"; });
    if (density_wanted() && !has_density)
      fault(fmt::format("--pdf: the density of samples \"{}\" is constant; the run file holds none",
                        problem_.samples.space));
    std::string why;
    if (!holds_channels(*container_, channels(), plan_.with_density, why)) {
      const std::string others = names_of([&](const Container& other) {
        std::string ignored;
        return holds_channels(other, channels(), plan_.with_density, ignored);
      });
      fault(why + (others.empty() ? "" : fmt::format("; accepted for them: {}", others)));
      return;
    }
    // The published files are PNGs whose vectors are RGBA.
    const bool as_published = naming_.scheme == NamingScheme::nvidia && container_->pixel == png_pixel &&
                              channels() > 1 && channels() < 4 && !plan_.with_density;
    main_.pixel = (as_published ? rgba_pixel : container_->pixel)(channels(), plan_.with_density);
  }

  void choose_range() {
    const bool must_fit = main_.type != PixelType::float32 || container_->numbers == StoredNumbers::unit;
    if (plan_.num_points) {
      plan_.range = ValueRange{};
    } else if (!options_.range.empty()) {
      if (container_->numbers == StoredNumbers::the_values)
        fault(fmt::format("--range: {} holds the values themselves", container_->name));
      plan_.range = parsed([&] { return parse_range(options_.range); });
    } else if (must_fit) {
      plan_.range = natural_range(problem_.samples);
      if (plan_.range) return;
      const std::string floats = names_of([](const Container& other) {
        return other.numbers != StoredNumbers::unit &&
               std::find(other.types.begin(), other.types.end(), PixelType::float32) != other.types.end();
      });
      fault(
          fmt::format("samples \"{}\" have no fixed range, and {} needs one: give --range LO:HI (values beyond are "
                      "clamped), or --depth 32f with {}",
                      problem_.samples.space,
                      container_->numbers == StoredNumbers::unit ? container_->name
                                                                 : fmt::format("a depth of {}", to_string(main_.type)),
                      floats));
    }
  }

  std::string target(const std::string& file) const { return (output_.folder / file).string(); }

  void choose_targets() {
    name_main_output();
    plan_.outputs.push_back(main_);
    if (options_.density == "separate") add_density_images();
    if (plan_.num_points) add_point_tables();
  }

  void name_main_output() {
    const SliceIndex count = plan_.extents.num_slices();
    const bool one_file = main_.layout != ExportLayout::slices;
    const bool own_name = !output_.file.empty() && !pattern_in_output_;
    if (own_name && (one_file || count == 1)) {
      main_.targets = {target(output_.file)};
      return;
    }
    std::string ending = fs::path(output_.file).extension().string();
    if (ending.empty()) ending = container_->endings.front();
    std::string stem = fs::path(name_).stem().string();
    if (own_name) {
      stem = fs::path(output_.file).stem().string();
    } else {
      stem = texture_name(naming_, problem_, stem, why_order_cannot_be_read(content_).empty());
      if (plan_.num_points) stem += "_below" + density_;
    }
    if (one_file) {
      if (naming_.scheme == NamingScheme::pattern)
        fault(fmt::format(
            "{}: numbers slices, but {} with layout {} is one file; leave the number out, or choose another "
            "--layout or --format",
            pattern_in_output_ ? "-o " + options_.output : "--naming " + options_.naming, container_->name,
            to_string(main_.layout)));
      main_.targets = {container_->content == ContainerContent::places ? target(table_stem() + ending)
                                                                       : target(stem + ending)};
      return;
    }
    for (SliceIndex s = plan_.begin; s < plan_.end; ++s)
      main_.targets.push_back(target(slice_file_name(naming_, stem, s, count, ending)));
  }

  // Beside each file of samples one of their densities, in one channel as the container holds scalars.
  void add_density_images() {
    ExportOutput beside = main_;
    beside.pixel = container_->pixel(1, false);
    std::replace(beside.pixel.source.begin(), beside.pixel.source.end(), 0, density_channel);
    for (std::string& file : beside.targets) {
      const fs::path path(file);
      file = (path.parent_path() / (path.stem().string() + "_pdf" + path.extension().string())).string();
    }
    plan_.outputs.push_back(beside);
  }

  // Of a table in a folder, where several point sets may lie; beside a file with a name of its own, after that.
  std::string table_stem() const {
    if (output_.file.empty() || pattern_in_output_) return "points_below" + density_;
    return fs::path(output_.file).stem().string() + "_points";
  }

  // The coordinates as text always, and in the container of the images, where that has a table too.
  void add_point_tables() {
    for (const Container& container : containers()) {
      if (container.content != ContainerContent::places || &container == container_) continue;
      if (container_->content == ContainerContent::places) continue;
      if (container.name != "csv" && container.name != container_->name) continue;
      ExportOutput table;
      table.container = &container;
      table.layout = container.layouts.front();
      table.targets = {target(table_stem() + container.endings.front())};
      plan_.outputs.push_back(table);
    }
  }

  const std::string& name_;
  const RunFileContent& content_;
  const ProblemSpec& problem_;
  const ExportOptions& options_;
  Output output_;
  bool pattern_in_output_ = false;
  Naming naming_;
  std::string density_;  // in digits, for names
  const Container* container_ = nullptr;
  ExportOutput main_;
  ExportPlan plan_;
  std::vector<Fault> faults_;
};

}  // namespace

ExportPlan plan_export(const std::string& name, const RunFileContent& content, const ProblemSpec& problem,
                       const ExportOptions& options) {
  return Planner(name, content, problem, options).plan();
}

}  // namespace noiseloom
