#include "noiseloom/config/config.h"

#include <fmt/format.h>

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "config/config_read.h"

namespace noiseloom {
namespace {

std::string read_text(const std::string& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (status.type() == std::filesystem::file_type::not_found) throw UserError(path, "no such file");
  if (std::filesystem::is_directory(status)) throw UserError(path, "is a folder, must be a config (TOML)");
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  if (file) text << file.rdbuf();
  if (!file || file.bad()) {
    throw EnvironmentError(path + ": cannot be read: " + std::strerror(errno == 0 ? EIO : errno));
  }
  return std::move(text).str();
}

}  // namespace

RunConfig parse_config(const std::string& text, const std::string& name, const std::string& folder,
                       const std::vector<std::string>& overrides, MissingFiles missing) {
  settings::Value root = settings::parse_tree(text, name);
  std::vector<Fault> override_faults;
  for (const std::string& override_text : overrides) settings::apply_override(root, override_text, override_faults);
  settings::ConfigReader reader(folder, missing);
  RunConfig config = reader.read(root);
  std::vector<Fault> faults = reader.faults();
  faults.insert(faults.end(), override_faults.begin(), override_faults.end());
  throw_if_any(std::move(faults));
  return config;
}

RunConfig load_config(const std::string& path, const std::vector<std::string>& overrides) {
  return parse_config(read_text(path), path, std::filesystem::path(path).parent_path().string(), overrides);
}

std::optional<double> parse_duration(std::string_view text) {
  struct Unit {
    char letter;
    double seconds;
  };
  constexpr Unit units[] = {{'d', 86400}, {'h', 3600}, {'m', 60}, {'s', 1}};
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  double total = 0;
  std::size_t next_unit = 0;
  for (bool first = true; first || !text.empty(); first = false) {
    if (text.empty() || !is_digit(text.front())) return std::nullopt;
    double number = 0;
    const char* const last = text.data() + text.size();
    const auto [end, error] = std::from_chars(text.data(), last, number, std::chars_format::fixed);
    if (error != std::errc{} || !std::isfinite(number)) return std::nullopt;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    if (text.empty()) return first ? std::optional(number) : std::nullopt;
    while (next_unit < std::size(units) && units[next_unit].letter != text.front()) ++next_unit;
    if (next_unit == std::size(units)) return std::nullopt;  // unknown, repeated, or a larger unit after a smaller one
    total += number * units[next_unit++].seconds;
    text.remove_prefix(1);
  }
  return total;
}

VacSpec vac_spec(const RunConfig& config) {
  VacSpec spec;
  spec.extents = config.problem.extents;
  for (const GroupSpec& group : config.problem.filter.groups) spec.groups.push_back({group.axes, group.kernel.sigma});
  if (!config.order.bounded.empty()) {
    spec.toroidal.assign(static_cast<std::size_t>(spec.extents.num_axes()), true);
    for (const int axis : config.order.bounded) spec.toroidal[static_cast<std::size_t>(axis)] = false;
  }
  spec.density = config.order.density;
  spec.seed = config.problem.seed;
  return spec;
}

}  // namespace noiseloom
