#include "noiseloom/image/naming.h"

#include <fmt/format.h>

#include <algorithm>
#include <regex>

#include "noiseloom/image/sequence.h"
#include "noiseloom/samples/space.h"

namespace noiseloom {
namespace {

std::string nvidia_type(const SampleSpec& samples, bool has_order) {
  if (samples.is_file()) return "file";
  const std::string name = space_traits(samples).nvidia_name;
  return has_order && name == "vec1" ? "scalar" : name;
}

std::string ea_space(const SampleSpec& samples) { return samples.is_file() ? "file" : space_traits(samples).ea_name; }

// "1.0", "1.3435" with another text for the point; always with one decimal at least, as in the published names.
std::string decimal(double value, const std::string& point) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_not_of("0123456789-") == std::string::npos) text += ".0";
  const std::size_t at = text.find('.');
  return at == std::string::npos ? text : text.replace(at, 1, point);
}

std::string ea_kernel(const GroupSpec& group) {
  const KernelSpec& kernel = group.kernel;
  const bool over_xy = std::any_of(group.axes.begin(), group.axes.end(), [](int axis) { return axis < 2; });
  const auto width = [](int taps) { return fmt::format("{0}x{0}", taps); };
  switch (kernel.kind) {
    case KernelKind::box:
      return over_xy ? "box" + width(kernel.size) : fmt::format("Box{}", kernel.size);
    case KernelKind::gauss:
      return over_xy ? "gauss" + decimal(kernel.sigma, "_") : "Gauss" + decimal(kernel.sigma, "");
    case KernelKind::binomial:
      return over_xy ? "binomial" + width(kernel.n + 1) : fmt::format("Binomial{}", kernel.n);
    case KernelKind::ema:
      return "exp" + decimal(kernel.alpha, "") + decimal(kernel.rejection, "");
    case KernelKind::table:
      return "table";
    case KernelKind::eye:
      return "eye" + decimal(kernel.frames_per_second, "") + "x" + decimal(kernel.pixels_per_degree, "");
    case KernelKind::gauss_energy:
      return "gaussenergy" + decimal(kernel.sigma, over_xy ? "_" : "");
  }
  return "table";
}

std::string nvidia_name(const ProblemSpec& problem, bool has_order) {
  constexpr int axes_of_a_mask = 4;
  std::string groups;
  for (const GroupSpec& group : problem.filter.groups)
    groups += fmt::format("{}{}D", groups.empty() ? "" : "x", group.axes.size());
  std::string size;
  for (int axis = 0; axis < problem.extents.num_axes(); ++axis)
    size += fmt::format("{}{}", axis == 0 ? "" : "x", problem.extents.size(axis));
  for (int axis = problem.extents.num_axes(); has_order && axis < axes_of_a_mask; ++axis) {
    groups += "x1D";
    size += "x1";
  }
  return fmt::format("stbn_{}_{}_{}", nvidia_type(problem.samples, has_order), groups, size);
}

std::string ea_name(const ProblemSpec& problem) {
  const FilterSpec& filter = problem.filter;
  std::string name = ea_space(problem.samples);
  for (const GroupSpec& group : filter.groups) name += fmt::format("_{}", ea_kernel(group));
  if (filter.groups.size() > 1)
    name += filter.combine == Combine::product ? "_product" : "_separate" + decimal(filter.groups.front().weight, "");
  return name;
}

constexpr const char* accepted_places = "{slice}, {slice:03}, {}, %d, %03d, %i, ####";

}  // namespace

std::string why_no_file_name(const std::string& name) {
  // What people write for a number and other programs understand.
  static const std::regex place(R"([*?]|%[-+ #]*\d*[diouxX]|\{[^{}]*\}|##+|@@+|\$F\d*|<[A-Za-z]\w*>)");
  std::smatch found;
  if (!std::regex_search(name, found, place)) return "";
  return fmt::format("\"{}\" is no place for the number of a slice; accepted, once, in the file's name: {}",
                     found.str(), accepted_places);
}

Naming parse_naming(const std::string& text) {
  if (text == "plain") return {NamingScheme::plain, ""};
  if (text == "nvidia") return {NamingScheme::nvidia, ""};
  if (text == "ea") return {NamingScheme::ea, ""};
  if (is_sequence_pattern(text)) {
    if (const std::string why = why_no_file_name(fill_pattern(text, 0)); !why.empty())
      throw UserError("command line", fmt::format("{}: {}", text, why));
    return {NamingScheme::pattern, text};
  }
  const std::string nearest = nearest_word(text, {"plain", "nvidia", "ea"});
  throw UserError(
      "command line",
      fmt::format("--naming {}: unknown scheme{}; accepted: plain, nvidia, ea, or a pattern such as "
                  "noise_{{slice}} (places for the number: {})",
                  text, nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest), accepted_places));
}

std::string texture_name(const Naming& naming, const ProblemSpec& problem, const std::string& stem, bool has_order) {
  switch (naming.scheme) {
    case NamingScheme::nvidia:
      return nvidia_name(problem, has_order);
    case NamingScheme::ea:
      return ea_name(problem);
    case NamingScheme::plain:
    case NamingScheme::pattern:
      return stem;
  }
  return stem;
}

std::string slice_file_name(const Naming& naming, const std::string& name, std::int64_t slice, std::int64_t num_slices,
                            const std::string& ending) {
  if (naming.scheme == NamingScheme::pattern) {
    const std::string filled = fill_pattern(naming.pattern, slice);
    return filled.ends_with(ending) ? filled : filled + ending;
  }
  if (naming.scheme == NamingScheme::nvidia) return fmt::format("{}_{}{}", name, slice, ending);
  if (num_slices == 1) return name + ending;
  if (naming.scheme == NamingScheme::ea) return fmt::format("{}_{}{}", name, slice, ending);
  const std::size_t digits = std::to_string(num_slices - 1).size();
  return fmt::format("{}_{:0{}}{}", name, slice, digits, ending);
}

std::string describe_filter(const Extents& extents, const FilterSpec& filter) {
  std::string text;
  for (const GroupSpec& group : filter.groups) {
    if (!text.empty()) text += filter.combine == Combine::product ? " x " : " + ";
    const KernelSpec& kernel = group.kernel;
    if (filter.combine == Combine::sum && filter.groups.size() > 1) text += fmt::format("{:.3g} ", group.weight);
    switch (kernel.kind) {
      case KernelKind::box:
        text += fmt::format("box {}", kernel.size);
        break;
      case KernelKind::gauss:
        text += fmt::format("gauss {}", kernel.sigma);
        break;
      case KernelKind::binomial:
        text += fmt::format("binomial {}", kernel.n);
        break;
      case KernelKind::ema:
        text += fmt::format("ema {} (rejection {})", kernel.alpha, kernel.rejection);
        break;
      case KernelKind::table:
        text += fmt::format("table {}", kernel.file);
        break;
      case KernelKind::eye:
        text += fmt::format("eye at {} frames a second and {} pixels a degree", kernel.frames_per_second,
                            kernel.pixels_per_degree);
        break;
      case KernelKind::gauss_energy:
        text += fmt::format("gauss-energy {}", kernel.sigma);
        break;
    }
    text += " over ";
    for (const int axis : group.axes) text += extents.name(axis);
  }
  return text;
}

}  // namespace noiseloom
