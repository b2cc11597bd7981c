// What the settings of a run ask of each other.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "config/run_settings.h"
#include "noiseloom/samples/sample_space.h"
#include "noiseloom/samples/space.h"

namespace noiseloom::settings {
namespace {

constexpr double max_sigma = 1000;  // check_vac_spec

// True for a known word that is not `wanted`: one that is not known has been reported already.
bool is_other_word(const Value* value, const Setting& setting, std::string_view wanted) {
  const std::string* text = value == nullptr ? nullptr : value->text();
  return text != nullptr && *text != wanted &&
         std::any_of(setting.words.begin(), setting.words.end(), [&](const Word& w) { return w.word == *text; });
}

void check_axes_are_disjoint(Reader& reader, const Found& found) {
  const Array& groups = *found.value.array();
  const std::vector<GroupSpec>& specs = found.owners.get<RunConfig>().problem.filter.groups;
  const std::vector<std::string> names = axis_names(reader.root());
  std::vector<std::size_t> owner(names.size(), groups.size());
  for (std::size_t i = 0; i < groups.size(); ++i) {
    for (const int axis : specs[i].axes) {
      std::size_t& first = owner[static_cast<std::size_t>(axis)];
      if (first == groups.size()) {
        first = i;
        continue;
      }
      reader.fault(*find(*groups[i].table(), "axes"), fmt::format("{}[{}].axes", found.shown, i),
                   fmt::format("axis {} is in {}[{}] already; with combine = \"product\" an axis belongs to one group",
                               toml_string(names[static_cast<std::size_t>(axis)]), found.shown, first));
    }
  }
}

void check_weights(Reader& reader, const Found& found) {
  std::vector<GroupSpec>& specs = found.owners.get<RunConfig>().problem.filter.groups;
  std::size_t num_given = 0;
  bool sound = true;
  double sum = 0;
  for (std::size_t i = 0; i < specs.size(); ++i) {
    const bool given = find_at((*found.value.array())[i], "weight") != nullptr;
    if (given) ++num_given;
    if (given && specs[i].weight == 0) sound = false;
    sum += specs[i].weight;
  }
  if (num_given == 0) {
    for (GroupSpec& spec : specs) spec.weight = 1.0 / static_cast<double>(specs.size());
  } else if (num_given < specs.size()) {
    reader.fault(found.value.place, fmt::format("{}: {} of {} groups have a weight; all must, or none (equal shares)",
                                                found.shown, num_given, specs.size()));
  } else if (sound && std::abs(sum - 1) > 1e-6) {
    reader.fault(found.value.place, fmt::format("{}: weights add up to {:.7g}; must add up to 1", found.shown, sum));
  }
}

// The box of a group's energy lies along slice axes of the group, and leaves an axis to the Gaussian.
void check_boxes(Reader& reader, const Found& found) {
  const std::vector<GroupSpec>& specs = found.owners.get<RunConfig>().problem.filter.groups;
  const std::vector<std::string> names = axis_names(reader.root());
  for (std::size_t i = 0; i < specs.size(); ++i) {
    const Value& group = (*found.value.array())[i];
    const Value* box = find_at(group, "box");
    const Value* size = find_at(group, "box_size");
    const std::string shown = fmt::format("{}[{}].", found.shown, i);
    if (box == nullptr && size == nullptr) continue;
    if (box == nullptr || size == nullptr) {
      reader.fault(box == nullptr ? size->place : box->place,
                   shown + (box == nullptr ? "box: missing; box_size says how many slices in a row act as one along it"
                                           : "box_size: missing; how many slices in a row act as one"));
      continue;
    }
    for (const int axis : specs[i].kernel.box_axes) {
      const std::string name = toml_string(names[static_cast<std::size_t>(axis)]);
      const bool in_group = std::find(specs[i].axes.begin(), specs[i].axes.end(), axis) != specs[i].axes.end();
      if (!in_group) {
        reader.fault(*box, shown + "box", fmt::format("axis {} is none of the group's", name));
      } else if (axis < 2) {
        reader.fault(*box, shown + "box", fmt::format("axis {} is no slice axis", name));
      }
    }
    if (!specs[i].axes.empty() && specs[i].kernel.box_axes.size() >= specs[i].axes.size()) {
      reader.fault(*box, shown + "box", "one axis of the group at least must be left to the Gaussian");
    }
  }
}

// Tiles are slices that share the edges of x and y; only an order of the volume has them, or a tail.
void check_order_energies(Reader& reader, const Value& groups, const RunConfig& config) {
  const std::vector<GroupSpec>& specs = config.problem.filter.groups;
  const std::vector<std::string> names = axis_names(reader.root());
  for (std::size_t i = 0; i < specs.size(); ++i) {
    const Value& group = (*groups.array())[i];
    const std::string shown = fmt::format("filter.groups[{}].", i);
    for (const char* key : {"tiles", "tail", "tail_power"}) {
      const Value* value = find_at(group, key);
      if (value != nullptr && config.optimizer.method != Method::void_and_cluster) {
        reader.fault(*value, shown + key, "is for method = \"void-and-cluster\" alone");
      }
    }
    const Value* power = find_at(group, "tail_power");
    if (power != nullptr && find_at(group, "tail") == nullptr) {
      reader.fault(*power, shown + "tail_power", "is of a tail, but there is no tail");
    }
    const Value* tiles = find_at(group, "tiles");
    if (tiles == nullptr) continue;
    const auto has = [&](const std::vector<int>& axes, int axis) {
      return std::find(axes.begin(), axes.end(), axis) != axes.end();
    };
    for (const int axis : specs[i].kernel.tile_axes) {
      const std::string name = toml_string(names[static_cast<std::size_t>(axis)]);
      if (!has(specs[i].axes, axis)) {
        reader.fault(*tiles, shown + "tiles", fmt::format("axis {} is none of the group's", name));
      } else if (axis < 2) {
        reader.fault(*tiles, shown + "tiles", fmt::format("axis {} is no slice axis", name));
      } else if (specs[i].is_box_along(axis)) {
        reader.fault(*tiles, shown + "tiles", fmt::format("axis {} is in box already", name));
      }
    }
    if (!specs[i].axes.empty() && !(has(specs[i].axes, 0) && has(specs[i].axes, 1))) {
      reader.fault(*tiles, shown + "tiles", "the group must have x and y, whose edges the tiles share");
    }
  }
}

// Void and cluster makes one order, of scalars, with the energy of Gaussians.
constexpr std::string_view with = "with method = \"void-and-cluster\" ";

void check_order_combine(Reader& reader, const Value& root) {
  const Value* groups = find_at(root, "filter.groups");
  const Value* combine = find_at(root, "filter.combine");
  if (groups->array()->size() < 2) return;
  const std::string sum = fmt::format("{}several groups need combine = \"sum\"", with);
  if (combine == nullptr) {
    reader.fault(groups->place, "filter.combine: missing; " + sum);
  } else if (is_other_word(combine, reader.kind().row("filter.combine"), "sum")) {
    reader.fault(*combine, "filter.combine", sum);
  }
}

// Of the order alone come scalars; along a curve it hands out the samples of each slice.
void check_order_samples(Reader& reader, const Value& root, const RunConfig& config) {
  const SampleSpec& spec = config.problem.samples;
  const Value* samples = find_at(root, "texture.samples");
  if (samples == nullptr || !reader.decided("texture.samples.space")) return;
  if (spec.curve == Curve::none) {
    if (spec.space == "uniform") return;
    return reader.fault(*samples, "texture.samples",
                        fmt::format("{}they must be \"uniform\", as the order of the pixels makes the values; or "
                                    "vector2, vector3 or vector4 along a curve (optimizer.curve)",
                                    with));
  }
  const Value* curve = find_at(root, "optimizer.curve");
  if (config.order.equalize != Equalize::slice) {
    reader.fault(*curve, "optimizer.curve",
                 fmt::format("{}it hands out the samples of each slice: add equalize = \"slice\"", with));
  }
  if (config.order.bits > 0) {
    reader.fault(*find_at(root, "optimizer.bits"), "optimizer.bits", "is for scalars; export rounds vectors");
  }
}

void check_order_group(Reader& reader, const Value& value, const GroupSpec& group, const std::string& shown) {
  const Value* kernel = find_at(value, "kernel");
  if (is_other_word(kernel, reader.kind().row("filter.groups[].kernel"), "gauss-energy")) {
    reader.fault(*kernel, shown + "kernel", fmt::format("{}it must be \"gauss-energy\"", with));
  }
  const Value* sigma = find_at(value, "sigma");
  if (sigma != nullptr && group.kernel.kind == KernelKind::gauss_energy && group.kernel.sigma > max_sigma) {
    reader.fault(*sigma, shown + "sigma", fmt::format("{}must be at most {}", with, max_sigma));
  }
}

}  // namespace

void check_groups(Reader& reader, const Found& found) {
  check_boxes(reader, found);
  const std::vector<GroupSpec>& groups = found.owners.get<RunConfig>().problem.filter.groups;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const bool in_plane = std::any_of(groups[i].axes.begin(), groups[i].axes.end(), [](int axis) { return axis < 2; });
    if (groups[i].kernel.kind != KernelKind::eye || !in_plane) continue;
    reader.fault(*find(*(*found.value.array())[i].table(), "axes"), fmt::format("{}[{}].axes", found.shown, i),
                 "the kernel \"eye\" is a filter over time: x and y have filters of their own");
  }
  if (!reader.decided("filter.combine")) return;
  const bool product = found.owners.get<RunConfig>().problem.filter.combine == Combine::product;
  product ? check_axes_are_disjoint(reader, found) : check_weights(reader, found);
}

void check_temperatures(Reader& reader, const Found& found) {
  const OptimizerSpec& optimizer = found.owners.get<RunConfig>().optimizer;
  if (optimizer.temperature_start > 0 && optimizer.temperature_end > optimizer.temperature_start) {
    reader.fault(found.value, found.shown, "end must not be above start");
  }
}

namespace {

void check_start_of_circle(Reader& reader, const Value& root, const RunConfig& config) {
  const Value* value = find_at(root, "optimizer.density");
  if (value == nullptr || config.construct.density == ConstructSpec{}.density) return;
  reader.fault(*value, "optimizer.density",
               "is for samples that are compared by their difference: on a circle "
               "construction starts from half of the pixels");
}

// Of a list from a file, only the file knows how many channels it has.
void check_construct(Reader& reader, const Value& root, const RunConfig& config) {
  const SampleSpec& spec = config.problem.samples;
  const Value* samples = find_at(root, "texture.samples");
  if (samples == nullptr) return;
  const std::optional<SampleScale> scale = scale_of(spec, spec.is_file() ? 1 : num_channels(spec));
  if (scale == SampleScale::circle) check_start_of_circle(reader, root, config);
  if (scale) return;
  std::string scalars;
  for (const SampleSpace* space : sample_spaces()) {
    if (space->traits().distance == DistanceKind::absolute) scalars += space->traits().name + ", ";
  }
  reader.fault(
      *samples, "texture.samples",
      fmt::format("with method = \"construct\" they must be scalars that are compared by their difference ({}or a file "
                  "of one channel) or \"circle\"; method = \"anneal\" takes all",
                  scalars));
}

void check_curve(Reader& reader, const Value& root, const SampleSpec& samples) {
  const Value* value = find_at(root, "optimizer.curve");
  if (value == nullptr || samples.curve == Curve::none || !reader.decided("texture.samples.space")) return;
  if (samples.space == "vector2" || samples.space == "vector3" || samples.space == "vector4") return;
  reader.fault(*value, "optimizer.curve",
               fmt::format("is for samples vector2, vector3 and vector4; here they are {}", samples.space));
}

// What `auto` stands for is known here, unless the samples are a list, and so is what does not go with it.
void check_auto(Reader& reader, const Value& root, RunConfig& config) {
  if (config.problem.samples.is_file()) return;
  settle_method(config, num_channels(config.problem.samples));
  if (config.optimizer.method != Method::anneal) return check_construct(reader, root, config);
  for (const char* key : {"optimizer.density", "optimizer.sharpness"}) {
    const Value* value = find_at(root, key);
    if (value != nullptr) reader.fault(*value, key, "is for construction alone, but method = \"auto\" anneals here");
  }
}

// Of a list from a file, only the file knows how many channels it has.
void check_start_pattern(Reader& reader, const Value& root, const RunConfig& config) {
  const Value* value = find_at(root, "optimizer.start.pattern");
  if (value == nullptr || config.start.pattern != StartPattern::lattice || !reader.decided("texture.samples.space"))
    return;
  const SampleSpec& samples = config.problem.samples;
  const bool is_scalar = samples.curve == Curve::none && (samples.is_file() || num_channels(samples) == 1);
  if (is_scalar && scale_of(samples, 1) == SampleScale::line) return;
  reader.fault(*value, "optimizer.start.pattern",
               "a lattice is for scalars that are compared by their difference (uniform, tent, gauss, exponential or a "
               "file of one channel)");
}

// Nets and orders have strata of their own, and who names the start has placed every sample.
void check_time_strata(Reader& reader, const Value& root, RunConfig& config) {
  ProblemSpec& problem = config.problem;
  const Value* value = find_at(root, "texture.stratify");
  const Value* sizes = find_at(root, "texture.size");
  if (value == nullptr || problem.stratify != Stratify::slice_and_time) return;
  constexpr const char* shown = "texture.stratify";
  const bool anneals = config.optimizer.method == Method::automatic || config.optimizer.method == Method::anneal;
  if (!anneals) reader.fault(*value, shown, "slice+time is for method = \"auto\" and \"anneal\"");
  if (space_traits(problem.samples).is_net) {
    reader.fault(*value, shown, fmt::format("slice+time does not go with the nets of {}", problem.samples.space));
  }
  if (config.start.is_given()) {
    reader.fault(*value, shown, "slice+time makes its own start; leave optimizer.start out");
  }
  if (sizes == nullptr || sizes->table() == nullptr) return;
  const Extents& extents = problem.extents;
  const int axis = extents.axis("t");
  if (axis < 2) return reader.fault(*value, shown, "slice+time needs a slice axis named t");
  const std::int64_t cells = extents.cells_per_slice();
  const std::int64_t length = extents.size(axis);
  if (fits_time_strata(extents, axis)) {
    config.optimizer.strata = narrow<int>(length);
    return;
  }
  const auto nearest = [&](std::int64_t step) {
    std::int64_t near = length;
    while (cells % near != 0) near += step;
    return near;
  };
  const std::int64_t below = nearest(-1);
  reader.fault(*value, shown,
               length > cells ? fmt::format("with slice+time t must divide the {} pixels of a slice, but is {}; the "
                                            "longest that does is {}",
                                            cells, length, cells)
                              : fmt::format("with slice+time t must divide the {} pixels of a slice, but is {}; the "
                                            "nearest that do are {} and {}",
                                            cells, length, below, nearest(1)));
}

}  // namespace

void check_method(Reader& reader, const Value& root, const Owners& owners) {
  RunConfig& config = owners.get<RunConfig>();
  check_curve(reader, root, config.problem.samples);
  check_sizes_of_nets(reader, root, config);
  check_time_strata(reader, root, config);
  check_start_pattern(reader, root, config);
  if (const Value* groups = find_at(root, "filter.groups"); groups != nullptr && groups->array() != nullptr) {
    check_order_energies(reader, *groups, config);
  }
  const bool may_construct =
      config.optimizer.method == Method::construct || config.optimizer.method == Method::automatic;
  if (may_construct && find_at(root, "optimizer.stop") == nullptr) config.optimizer.stop = StopSpec::none();
  if (config.optimizer.method == Method::automatic) return check_auto(reader, root, config);
  if (config.optimizer.method == Method::construct) check_construct(reader, root, config);
  if (config.optimizer.method != Method::void_and_cluster) return;
  check_order_samples(reader, root, config);
  const Value* groups = find_at(root, "filter.groups");
  if (groups == nullptr || groups->array() == nullptr || groups->array()->empty()) return;
  check_order_combine(reader, root);
  for (std::size_t i = 0; i < groups->array()->size(); ++i) {
    check_order_group(reader, (*groups->array())[i], config.problem.filter.groups[i],
                      fmt::format("filter.groups[{}].", i));
  }
}

}  // namespace noiseloom::settings
