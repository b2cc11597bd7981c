// Light through a volume, with one number for each pixel.
//
//   free flight   the ray is cut into n steps, of which each has the density of its middle. The light scatters in the
//                 first step k where the optical depth S_k up to its end is above -ln(1 - u), which is where the share
//                 1 - e^-S_k that is scattered by then is above u, and is what reaches that place; else the background
//                 is seen. The mean over u is
//                    sum_k (e^-S_(k-1) - e^-S_k) L_k + e^-S_n background
//                 "above", not "at least": where there is nothing, nothing scatters, whatever the number.
//   ray march     n steps of equal length, all begun at the part u of their length: sum_k T_k (1 - e^-(d_k/n)) L_k +
//                 T_n background. It is biased by its steps; its own mean over u is its truth, and what the bias is
//                 stands beside it.
#include <algorithm>
#include <numeric>
#include <span>

#include "noiseloom/core/error.h"
#include "render/effects/effect-inl.h"
#include "render/jobs/effect_list.h"

namespace noiseloom::render {
namespace {

struct FreeFlightEffect : PlainEffect {
  FreeFlightEffect(const Shared& shared, int, const Job*)
      : flights(&shared.flights.get(Data::flights, shared.pass_or("free-flight"))),
        width(shared.scene.width),
        height(shared.scene.height) {}

  int channels() const { return 1; }
  int numbers() const { return 1; }

  std::size_t first(int x, int y) const {
    return (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) *
           static_cast<std::size_t>(flights->steps);
  }
  void estimate(int x, int y, Draw draw, float* out) const {
    const float* const scattered = flights->scattered.data() + first(x, y);
    const float* const end = scattered + flights->steps;
    const float* const step = std::upper_bound(scattered, end, draw(0));
    out[0] = step == end ? static_cast<float>(background(y, height))
                         : flights->light[first(x, y) + static_cast<std::size_t>(step - scattered)];
  }
  void expect(int x, int y, double* out) const {
    const std::size_t begin = first(x, y);
    double sum = 0;
    double before = 0;
    for (std::size_t k = begin; k < begin + static_cast<std::size_t>(flights->steps); ++k) {
      const double after = static_cast<double>(flights->scattered[k]);
      sum += (after - before) * static_cast<double>(flights->light[k]);
      before = after;
    }
    out[0] = sum + (1 - before) * background(y, height);
  }

  const Flights* flights;
  int width;
  int height;
};

float march(const Columns& columns, std::size_t first, int steps, float offset, float behind) {
  const Node* const column = columns.values.data() + first;
  const float step = 1 / static_cast<float>(steps);
  float sum = 0;
  float through = 1;
  for (int k = 0; k < steps; ++k) {
    const float z = (static_cast<float>(k) + offset) * step;
    const Node node = along(column, columns.nodes, z);
    const float kept = exp_minus(step * node.density);
    sum += through * (1 - kept) * node.light;
    through *= kept;
  }
  return sum + through * behind;
}

// Densities are linear between nodes, so that what a march gives is smooth in its offset but where one of its places
// passes a node. How many parts the offsets, 0 to 1, are cut into so that this happens at the ends of parts alone; more
// where the depth of a step changes much from one to the next.
int smooth_parts(const Scene& scene, int nodes) {
  const int steps = scene.ray_march.steps;
  const double change = scene.volume.extinction / (1.0 * nodes * steps);
  const int cut = static_cast<int>(std::clamp(std::ceil(16 * change), 1.0, 32.0));
  return (nodes - 1) / std::gcd(nodes - 1, steps) * cut;
}
// Places and weights of Gauss and Legendre's rule in such a part; of many steps each matters little, and the middle
// does.
struct RulePoint {
  double place;
  double weight;
};
std::span<const RulePoint> rule_of(int steps) {
  static constexpr RulePoint middle[] = {{0.5, 1}};
  static constexpr RulePoint three[] = {
      {0.1127016653792583, 5.0 / 18}, {0.5, 8.0 / 18}, {0.8872983346207417, 5.0 / 18}};
  constexpr int many = 16;
  return steps < many ? std::span<const RulePoint>(three) : std::span<const RulePoint>(middle);
}
int places_of_mean(const Scene& scene, int nodes) {
  return smooth_parts(scene, nodes) * static_cast<int>(rule_of(scene.ray_march.steps).size());
}
constexpr int fine_steps = 512;  // of what both tend to

struct RayMarchEffect : PlainEffect {
  RayMarchEffect(const Shared& shared, int, const Job*)
      : columns(&shared.columns.get(Data::columns, shared.pass_or("ray-march"))),
        steps(shared.scene.ray_march.steps),
        parts_of_mean(smooth_parts(shared.scene, columns->nodes)),
        width(shared.scene.width),
        height(shared.scene.height) {}

  int channels() const { return 1; }
  int numbers() const { return 1; }

  int march_steps() const { return steps; }

  std::size_t first(int x, int y) const {
    return (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) *
           static_cast<std::size_t>(columns->nodes);
  }
  void estimate(int x, int y, Draw draw, float* out) const {
    out[0] = march(*columns, first(x, y), steps, draw(0), static_cast<float>(background(y, height)));
  }
  void expect(int x, int y, double* out) const {
    const int parts = parts_of_mean;
    double sum = 0;
    for (int i = 0; i < parts; ++i)
      for (const RulePoint& point : rule_of(steps))
        sum += point.weight *
               static_cast<double>(march(*columns, first(x, y), steps, static_cast<float>((i + point.place) / parts),
                                         static_cast<float>(background(y, height))));
    out[0] = sum / parts;
  }

  const Columns* columns;
  int steps;
  int parts_of_mean;
  int width;
  int height;
};

Counts steps_of_march(std::int64_t number) {
  Counts counts{};
  count_of(counts, Work::march_steps) = number;
  return counts;
}

// What both tend to with ever smaller steps.
Image fine_march(const Shared& shared) {
  const Columns& columns = shared.columns.get(Data::columns, "truth");
  Image image = make_image(shared.scene.width, shared.scene.height, 1);
  shared.pool.for_each(image.height, [&](std::int64_t row, int) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < image.width; ++x)
      image.row(0, y)[x] =
          march(columns,
                (static_cast<std::size_t>(y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(x)) *
                    static_cast<std::size_t>(columns.nodes),
                fine_steps, 0.5F, static_cast<float>(background(y, image.height)));
  });
  return image;
}

}  // namespace

Flights make_flights(const Columns& columns, int steps) {
  const auto nodes = static_cast<std::size_t>(columns.nodes);
  const std::size_t pixels = columns.values.size() / nodes;
  Flights flights{.steps = steps, .scattered = {}, .light = {}};
  for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
    double depth = 0;
    for (int k = 0; k < steps; ++k) {
      const float z = (static_cast<float>(k) + 0.5F) / static_cast<float>(steps);
      const Node node = along(columns.values.data() + pixel * nodes, columns.nodes, z);
      depth += static_cast<double>(node.density) / steps;
      flights.scattered.push_back(static_cast<float>(1 - math::exp(-depth)));
      flights.light.push_back(node.light);
    }
  }
  return flights;
}

const EffectCalls free_flight_calls = {Effect::free_flight,
                                       [](const Scene&) { return 1; },
                                       [](const Scene&, const Noise& noise) { return if_numbers(1, noise); },
                                       [](const Scene&) { return false; },
                                       estimate_image<FreeFlightEffect>,
                                       truth_image<FreeFlightEffect>,
                                       fine_march,
                                       [](const Scene&) { return steps_of_march(fine_steps); }};

const EffectCalls ray_march_calls = {
    Effect::ray_march,
    [](const Scene&) { return 1; },
    [](const Scene&, const Noise& noise) { return if_numbers(1, noise); },
    [](const Scene&) { return false; },
    estimate_image<RayMarchEffect>,
    truth_image<RayMarchEffect>,
    fine_march,
    [](const Scene& scene) {
      const int nodes = scene.volume.density == Density::slab ? 2 : scene.volume.resolution;
      const int n = scene.ray_march.steps;
      return steps_of_march(std::int64_t{places_of_mean(scene, nodes)} * n + fine_steps);
    }};

}  // namespace noiseloom::render
