// plan as lines for people.

#include <fmt/format.h>

#include <algorithm>

#include "noiseloom/core/quantity_text.h"
#include "noiseloom_plan.h"

namespace noiseloom {
namespace {

class Lines {
 public:
  template <class... Arguments>
  void add(const char* label, fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    text_ += fmt::format("{:<10} {}\n", label, fmt::format(format, std::forward<Arguments>(arguments)...));
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

const char* plural(std::int64_t count) { return count == 1 ? "" : "s"; }

void add_problem(const RunPlan& plan, Lines& lines) {
  lines.add("texture", "{} ({} pixels, {} channel{})", plan.texture, plan.pixels, plan.channels, plural(plan.channels));
  lines.add("samples", "{}", plan.samples);
  lines.add("method", "{}", plan.method);
  std::string reach;
  for (std::size_t axis = 0; axis < plan.filter.reach.size(); ++axis) {
    reach += fmt::format(" {} {}", plan.axis_names[axis], plan.filter.reach[axis]);
  }
  lines.add("footprint", "{}{} taps{}{}", plan.filter.exact ? "" : "about ", plan.filter.taps,
            reach.empty() ? "" : ", reach", reach);
  for (const PlanEffect& axis : plan.axes) {
    const std::string why = axis.why.empty() ? "" : axis.on ? ", " + axis.why : " (" + axis.why + ")";
    lines.add("axis", "{}: {}{}", axis.name, axis.on ? "on" : "off", why);
  }
  for (const PlanEffect& effect : plan.effects) {
    lines.add("part", "{}: {} ({})", effect.name, effect.on ? "on" : "off", effect.why);
  }
  if (plan.features.empty()) return;
  std::string counts;
  for (const PlanFeatures& moment : plan.features) {
    counts += fmt::format("{}{} ({:.2g} %)", counts.empty() ? "" : ", ", moment.count, 100 * moment.missed);
  }
  lines.add("background", "other slices act through {} features (and the share of the variance that they miss)",
            counts);
}

void add_ranks(const RunPlan& plan, Lines& lines) {
  const int ranks = plan.request.ranks;
  lines.add("ranks", "{} of {} thread{}", ranks, plan.request.threads, plural(plan.request.threads));
  std::string text;
  const std::size_t shown = plan.ranks.size() <= 16 ? plan.ranks.size() : 4;
  for (std::size_t k = 0; k < plan.ranks.size(); ++k) {
    if (k == shown) lines.add("  ...", "");
    if (k >= shown && k + 2 < plan.ranks.size()) continue;
    const PlanRank& rank = plan.ranks[k];
    lines.add(fmt::format("  rank {:4}", rank.rank.value()).c_str(), " {} slices{}, {}", rank.slices,
              plan.method == "void-and-cluster" ? "" : fmt::format(", {} halo slices", rank.halo_slices),
              bytes_text(rank.bytes));
  }
  if (plan.idle_ranks > 0)
    lines.add("", "{} rank{} would have no slice and only wait", plan.idle_ranks, plural(plan.idle_ranks));
}

void add_memory(const RunPlan& plan, Lines& lines) {
  lines.add("memory", "at most {} a rank of {} thread{}", bytes_text(plan.most.peak()), plan.request.threads,
            plural(plan.request.threads));
  const int on_node =
      plan.request.ranks_per_node > 0 ? std::min(plan.request.ranks_per_node, plan.request.ranks) : plan.request.ranks;
  if (plan.request.ranks > 1) {
    lines.add("", "at most {} a node of {} rank{}", bytes_text(plan.node_bytes), on_node, plural(on_node));
  }
  const PlanMemory& most = plan.most;
  lines.add("", "program {}, slices {}, halo {}, filter {}, threads {}", bytes_text(most.program),
            bytes_text(most.texture), bytes_text(most.halo), bytes_text(most.filter), bytes_text(most.threads));
  if (most.inputs > 0) {
    lines.add("", "files {}{}", bytes_text(most.inputs), plan.request.ranks > 1 ? ", once a node" : "");
  }
  lines.add("", "and for a while: start {}, moves {}, scores {}, saves {}", bytes_text(most.at_start),
            bytes_text(most.at_move), bytes_text(most.at_score), bytes_text(most.at_save));
  lines.add("run file", "{}; {} on disk at a save, when two generations and the new file are there",
            bytes_text(plan.run_file_bytes), bytes_text(plan.disk_bytes));
}

void add_exchange(const RunPlan& plan, Lines& lines) {
  if (plan.request.ranks == 1) {
    lines.add("exchange", "none: one rank");
  } else if (plan.method == "void-and-cluster" && plan.exchange.bytes == 0) {
    lines.add("exchange", "hardly any: one rank has the only slice, and tells how many pixels it has placed");
  } else if (plan.method == "void-and-cluster") {
    lines.add("exchange", "candidates for the picks, a batch at a time; about {} in all",
              bytes_text(plan.exchange.bytes));
  } else if (plan.filter.coupled_slices == 0) {
    lines.add("exchange", "none: slices are not coupled");
  } else if (plan.method == "construct") {
    lines.add("exchange", "picks, after every colour class; about {} in all", bytes_text(plan.exchange.bytes));
  } else {
    lines.add("exchange", "{:.0f} slice updates a sweep in {:.0f} messages, about {}", plan.exchange.slice_updates,
              plan.exchange.messages, bytes_text(plan.exchange.bytes));
  }
}

void add_time(const RunPlan& plan, Lines& lines) {
  const PlanTime& time = plan.time;
  if (plan.method == "void-and-cluster") {
    lines.add("phases", "swap: about {:.0f} swaps of {:.0f} points; drain: {:.0f} places; fill: {:.0f} places",
              plan.phases.swaps, plan.phases.points, plan.phases.points,
              static_cast<double>(plan.pixels) - plan.phases.points);
    lines.add("speed", "{:.3g} us a pick on one thread here, measured on {}{}", time.candidate_us,
              plan.phases.measured_on,
              plan.phases.measured_on == plan.texture ? "" : "; slower where the texture leaves the caches");
  } else if (plan.method == "construct") {
    lines.add("speed", "{:.3g} us a pixel, measured here on one thread", time.candidate_us);
  } else {
    lines.add("speed", "{:.3g} us a candidate, measured here on one thread; {} iterations a sweep", time.candidate_us,
              plan.iterations_per_sweep);
  }
  const std::string parts = fmt::format(
      "start {}, moves {}, scores {}{}, exchange {}, saves {}", duration_text(time.start), duration_text(time.moves),
      duration_text(time.scores), time.num_scores > 0 ? fmt::format(" ({})", time.num_scores) : "",
      duration_text(time.exchange), duration_text(time.saves));
  const double total = time.total();
  const std::string range =
      fmt::format("mostly {} to {}", duration_text(total / time.spread), duration_text(total * time.spread));
  if (time.stop == "order" || time.stop == "construction") {
    lines.add("time", "about {}, {}", duration_text(total), range);
  } else if (time.stop == "iterations") {
    lines.add("time", "about {} for {} iterations, {}", duration_text(total), time.iterations, range);
  } else if (time.stop == "time") {
    lines.add("time", "as long as stop.time says; 1000 iterations would take about {}, {}", duration_text(total),
              range);
  } else {
    lines.add("time", "until stop.{} is reached; 1000 iterations take about {}, {}", time.stop, duration_text(total),
              range);
  }
  lines.add("", "{}", parts);
}

}  // namespace

std::string plan_text(const RunPlan& plan) {
  Lines lines;
  add_problem(plan, lines);
  add_ranks(plan, lines);
  add_memory(plan, lines);
  add_exchange(plan, lines);
  add_time(plan, lines);
  return lines.text();
}

}  // namespace noiseloom
