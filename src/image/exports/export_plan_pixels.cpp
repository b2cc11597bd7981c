#include "image/exports/export_planner.h"
#include "image/pixels/texel_formats.h"

#include <fmt/format.h>

#include <fmt/ranges.h>

#include <algorithm>
#include <string_view>

namespace noiseloom {

int ExportPlanner::channels() const {
  if (plan_.num_points) return 1;
  for (const SliceDataset& dataset : content_.datasets)
    if (dataset.name == "/samples") return dataset.channels;
  return 0;
}

void ExportPlanner::choose_pixel() {
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
    const std::string others = names_of_containers([&](const Container& other) {
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
  choose_pixel_size();
}

// The channels that --channels asks for.
void ExportPlanner::choose_pixel_size() {
  if (options_.channels.empty()) return;
  constexpr std::string_view letters = "RGBA";
  std::vector<std::string> accepted;
  for (const int size : container_->pixel_sizes) {
    if (size < channels()) continue;
    // Of three channels DXGI knows floats of 32 bits alone.
    if (container_->name == "dds" && texel_format(main_.type, size)->dxgi == 0) continue;
    accepted.emplace_back(letters.substr(0, static_cast<std::size_t>(size)));
    if (accepted.back() != options_.channels) continue;
    main_.pixel = pixel_of_size(size, channels());
    if (plan_.with_density)
      fault(fmt::format("--channels {}: --pdf alpha is RGBA already; leave one out", options_.channels));
    return;
  }
  fault(fmt::format("--channels {}: accepted for samples of {} in {}: {}", options_.channels,
                    channels() == 1 ? "one channel" : fmt::format("{} channels", channels()), container_->name,
                    accepted.empty() ? "what they have" : fmt::format("{}", fmt::join(accepted, ", "))));
}

void ExportPlanner::choose_range() {
  const bool must_fit = is_integer(main_.type) || container_->numbers == StoredNumbers::unit;
  if (plan_.num_points) {
    plan_.range = ValueRange{};
  } else if (!options_.range.empty()) {
    if (container_->numbers == StoredNumbers::the_values)
      fault(fmt::format("--range: {} holds the values themselves", container_->name));
    plan_.range = parsed([&] { return parse_range(options_.range); });
  } else if (must_fit) {
    plan_.range = natural_range(problem_.samples);
    if (plan_.range) return;
    const std::string floats = names_of_containers([](const Container& other) {
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

}  // namespace noiseloom
