#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>

#include "noiseloom/files/pixel_order.h"
#include "noiseloom/image/export.h"
#include "noiseloom/image/sequence.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {
namespace {

namespace fs = std::filesystem;

struct FormatRow {
  std::string name;
  std::vector<std::string> extensions;  // the first is what files get
  std::optional<ImageFormat> image;
  std::vector<std::string> depths;   // the first is the default
  std::vector<std::string> layouts;  // the first is the default
};

const std::vector<FormatRow>& formats() {
  static const std::vector<FormatRow> rows = {
      {"png", {".png"}, ImageFormat::png, {"8", "16"}, {"slices", "strip"}},
      {"exr", {".exr"}, ImageFormat::exr, {"32f"}, {"slices", "strip", "exr-multipart"}},
      {"tiff", {".tif", ".tiff"}, ImageFormat::tiff, {"8", "16", "32f"}, {"slices", "strip"}},
      {"hdr", {".hdr"}, ImageFormat::hdr, {"32f"}, {"slices", "strip"}},
      {"npy", {".npy"}, std::nullopt, {"32f"}, {}},
      {"raw", {".raw"}, std::nullopt, {"32f", "8", "16"}, {}},
  };
  return rows;
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

std::vector<std::string> format_names() {
  std::vector<std::string> names;
  for (const FormatRow& row : formats()) names.push_back(row.name);
  return names;
}

const FormatRow* row_of_extension(const std::string& extension) {
  for (const FormatRow& row : formats())
    if (std::find(row.extensions.begin(), row.extensions.end(), extension) != row.extensions.end()) return &row;
  return nullptr;
}

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

class Planner {
 public:
  Planner(const std::string& name, const RunFileContent& content, const ProblemSpec& problem,
          const ExportOptions& options)
      : name_(name), content_(content), problem_(problem), options_(options), output_(split_output(options.output)) {}

  ExportPlan plan() {
    const FormatRow* const row = choose_format();
    if (row == nullptr) throw_if_any(faults_);
    plan_.format = row->name;
    plan_.image = row->image;
    choose_depth(*row);
    choose_layout(*row);
    choose_slices();
    choose_points();
    choose_pixel(*row);
    choose_range(*row);
    throw_if_any(faults_);
    choose_targets(*row);
    throw_if_any(faults_);
    return plan_;
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

  const FormatRow* choose_format() {
    const std::string extension = fs::path(output_.file).extension().string();
    const FormatRow* const by_extension = row_of_extension(extension);
    if (!extension.empty() && by_extension == nullptr) {
      fault(fmt::format("-o {}: \"{}\" is no extension of a format that is written; accepted: {} (a folder ends in /)",
                        options_.output, extension, joined(format_names())));
      return nullptr;
    }
    if (options_.format.empty()) return by_extension != nullptr ? by_extension : &formats().front();
    for (const FormatRow& row : formats()) {
      if (row.name != options_.format) continue;
      if (by_extension != nullptr && by_extension != &row)
        fault(fmt::format("--format {}, but -o {} ends in {}", row.name, options_.output, extension));
      return &row;
    }
    const std::string nearest = nearest_word(options_.format, format_names());
    fault(fmt::format("--format {}: not written{}; accepted: {}", options_.format,
                      nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest), joined(format_names())));
    return nullptr;
  }

  void choose_depth(const FormatRow& row) {
    const std::string depth = options_.depth.empty() ? row.depths.front() : options_.depth;
    if (std::find(row.depths.begin(), row.depths.end(), depth) == row.depths.end())
      fault(fmt::format("--depth {}: {} does not hold it; accepted for {}: {}", depth, row.name, row.name,
                        joined(row.depths)));
    plan_.type = depth == "8" ? PixelType::uint8 : depth == "16" ? PixelType::uint16 : PixelType::float32;
  }

  void choose_layout(const FormatRow& row) {
    plan_.layout = ExportLayout::array;
    if (!options_.layout.empty() &&
        std::find(row.layouts.begin(), row.layouts.end(), options_.layout) == row.layouts.end()) {
      fault(row.layouts.empty()
                ? fmt::format("--layout {}: {} always holds the whole array", options_.layout, row.name)
                : fmt::format("--layout {}: accepted for {}: {}", options_.layout, row.name, joined(row.layouts)));
    } else if (!row.layouts.empty()) {
      const std::string layout = options_.layout.empty() ? row.layouts.front() : options_.layout;
      plan_.layout = layout == "strip"           ? ExportLayout::strip
                     : layout == "exr-multipart" ? ExportLayout::parts
                                                 : ExportLayout::slices;
    }
  }

  void choose_slices() {
    const SliceIndex count = content_.extents.num_slices();
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
    if (options_.threshold.empty()) return;
    plan_.num_points = 1;
    if (const std::string why = why_no_order(content_); !why.empty()) faults_.push_back({name_, why});
    if (options_.with_density) fault("--pdf: a point set (--threshold) has no density");
    if (!options_.range.empty()) fault("--range: a point set (--threshold) holds black and white alone");
    const std::optional<DecimalFraction> fraction =
        parsed([&] { return std::optional(parse_fraction("--threshold", options_.threshold)); });
    if (!fraction) return;
    const std::int64_t num_pixels = content_.extents.num_cells();
    plan_.num_points = fraction->floor_of_times(num_pixels);
    if (*plan_.num_points == 0)
      fault(fmt::format("--threshold {}: that is no point of {} pixels; the least that is one: {:.3g}",
                        options_.threshold, num_pixels, 1 / static_cast<double>(num_pixels)));
  }

  int channels() const {
    if (plan_.num_points) return 1;
    for (const SliceDataset& dataset : content_.datasets)
      if (dataset.name == "/samples") return dataset.channels;
    return 0;
  }

  void choose_pixel(const FormatRow& row) {
    if (plan_.num_points) {
      choose_plain_pixel(row);
      return;
    }
    plan_.with_density = options_.with_density;
    const bool has_density = std::any_of(content_.datasets.begin(), content_.datasets.end(),
                                         [](const SliceDataset& dataset) { return dataset.name == "/pdf"; });
    if (options_.with_density && !has_density)
      fault(fmt::format("--pdf: the density of samples \"{}\" is constant; the run file holds none",
                        sample_space_name(problem_.samples)));
    if (options_.with_density && !row.image) fault("--pdf: accepted with png, exr, tiff");
    choose_plain_pixel(row);
  }
  void choose_plain_pixel(const FormatRow& row) {
    if (!row.image) {
      for (int c = 0; c < channels(); ++c) plan_.pixel.source.push_back(c);
      return;
    }
    std::string why;
    const auto layout = pixel_layout(*row.image, channels(), plan_.with_density, why);
    if (layout)
      plan_.pixel = *layout;
    else
      fault(why);
  }

  // Integers, and hdr, which holds no negative numbers, store values as 0..1.
  void choose_range(const FormatRow& row) {
    const bool must_fit = plan_.type != PixelType::float32 || row.name == "hdr";
    if (plan_.num_points) {
      plan_.range = ValueRange{};
    } else if (!options_.range.empty()) {
      if (row.name == "npy") fault("--range: npy holds the values themselves");
      plan_.range = parsed([&] { return parse_range(options_.range); });
    } else if (must_fit) {
      plan_.range = natural_range(problem_.samples);
      if (!plan_.range)
        fault(
            fmt::format("samples \"{}\" have no fixed range, and {} needs one: give --range LO:HI (values beyond are "
                        "clamped), or --depth 32f with exr, tiff, npy or raw",
                        sample_space_name(problem_.samples),
                        row.name == "hdr" ? "hdr" : fmt::format("a depth of {}", to_string(plan_.type))));
    }
  }

  void name_points(const std::string& stem) {
    if (!plan_.num_points) return;
    plan_.points_csv = (output_.folder / (stem + ".csv")).string();
    if (plan_.format == "npy") plan_.points_npy = (output_.folder / (stem + ".npy")).string();
  }

  void choose_targets(const FormatRow& row) {
    const std::string stem = fs::path(name_).stem().string();
    std::string naming_text = options_.naming;
    const bool pattern_in_output = !output_.file.empty() && is_sequence_pattern(output_.file);
    if (pattern_in_output && !naming_text.empty())
      fault(fmt::format("-o {} is a pattern already; leave --naming out", options_.output));
    if (pattern_in_output) naming_text = output_.file;
    const Naming naming = parsed([&] { return parse_naming(naming_text.empty() ? "plain" : naming_text); });
    const std::string extension =
        output_.file.empty() ? row.extensions.front() : fs::path(output_.file).extension().string();
    const SliceIndex count = content_.extents.num_slices();
    const auto target = [&](const std::string& file) { return (output_.folder / file).string(); };
    const bool single = plan_.layout != ExportLayout::slices || count == 1;
    if (!output_.file.empty() && !pattern_in_output) {
      if (!options_.naming.empty() && naming.scheme != NamingScheme::plain)
        fault(fmt::format("--naming {} names the files itself: give a folder, not -o {}", options_.naming,
                          options_.output));
      const std::string own_stem = fs::path(output_.file).stem().string();
      name_points(own_stem + "_points");
      if (single)
        plan_.targets = {target(output_.file)};
      else
        for (SliceIndex s = plan_.begin; s < plan_.end; ++s)
          plan_.targets.push_back(target(slice_file_name(naming, own_stem, s, count, extension)));
      return;
    }
    name_points("points");
    const std::string whole =
        texture_name(naming, problem_, stem) + (plan_.num_points ? "_below" + options_.threshold : "");
    if (plan_.layout != ExportLayout::slices) {
      if (naming.scheme == NamingScheme::pattern) fault("a pattern names slices; the layout is one file");
      plan_.targets = {target(whole + extension)};
      return;
    }
    for (SliceIndex s = plan_.begin; s < plan_.end; ++s)
      plan_.targets.push_back(target(slice_file_name(naming, whole, s, count, extension)));
  }

  const std::string& name_;
  const RunFileContent& content_;
  const ProblemSpec& problem_;
  const ExportOptions& options_;
  Output output_;
  ExportPlan plan_;
  std::vector<Fault> faults_;
};

}  // namespace

ExportPlan plan_export(const std::string& name, const RunFileContent& content, const ProblemSpec& problem,
                       const ExportOptions& options) {
  return Planner(name, content, problem, options).plan();
}

}  // namespace noiseloom
