#include "image/exports/export_planner.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "noiseloom/core/decimal.h"
#include "noiseloom/files/pixel_order.h"

namespace noiseloom {

// A count on the command line, 1 to `most`.
std::int32_t ExportPlanner::count_of(const std::string& option, const std::string& text, std::int32_t most) {
  if (text.empty()) return 1;
  std::int32_t count = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), count);
  if (error == std::errc{} && stop == text.data() + text.size() && count >= 1 && count <= most) return count;
  fault(fmt::format("{} {}: must be from 1 to {}", option, text, most));
  return 1;
}

void ExportPlanner::choose_frames() {
  plan_.extents = content_.extents;
  if (options_.frames.empty() && options_.values.empty() && options_.read.empty()) return;
  constexpr std::int32_t most_frames = 1'000'000;
  constexpr std::int32_t most_values = 1024;
  const Extents& texture = content_.extents;
  const std::int32_t values = count_of("--values", options_.values, most_values);
  const std::int32_t frames =
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

void ExportPlanner::choose_slices() {
  const std::int32_t count = plan_.extents.num_slices();
  plan_.begin = 0;
  plan_.end = count;
  if (options_.slices.empty()) return;
  const std::string& text = options_.slices;
  const std::size_t colon = text.find(':');
  const auto number = [&](std::size_t begin, std::size_t end, std::int32_t& value) {
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
void ExportPlanner::choose_points() {
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

}  // namespace noiseloom
