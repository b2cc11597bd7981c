// plan as one JSON object for programs.

#include <fmt/format.h>

#include "noiseloom/core/json.h"
#include "noiseloom_plan.h"

namespace noiseloom {
namespace {

// The members of an object, one after another.
class Object {
 public:
  Object& raw(const char* name, const std::string& value) {
    text_ += fmt::format("{}\"{}\": {}", text_.empty() ? "" : ", ", name, value);
    return *this;
  }
  Object& text(const char* name, const std::string& value) { return raw(name, json_string(value)); }
  Object& number(const char* name, double value) { return raw(name, json_number(value)); }
  Object& count(const char* name, std::int64_t value) { return raw(name, std::to_string(value)); }
  Object& flag(const char* name, bool value) { return raw(name, value ? "true" : "false"); }
  std::string str() const { return "{" + text_ + "}"; }

 private:
  std::string text_;
};

template <class Items, class ToText>
std::string list(const Items& items, const ToText& to_text) {
  std::string text;
  for (const auto& item : items) text += (text.empty() ? "" : ", ") + to_text(item);
  return "[" + text + "]";
}

std::string effects(const std::vector<PlanEffect>& effects) {
  return list(effects, [](const PlanEffect& effect) {
    return Object().text("name", effect.name).flag("on", effect.on).text("why", effect.why).str();
  });
}

std::string footprint(const RunPlan& plan) {
  Object reach;
  for (std::size_t axis = 0; axis < plan.filter.reach.size(); ++axis) {
    reach.count(plan.axis_names[axis].c_str(), plan.filter.reach[axis]);
  }
  return Object()
      .count("taps", plan.filter.taps)
      .count("judged_taps", plan.filter.judged_taps)
      .count("coupled_slices", plan.filter.coupled_slices)
      .raw("reach", reach.str())
      .flag("exact", plan.filter.exact)
      .str();
}

std::string memory(const RunPlan& plan) {
  const PlanMemory& most = plan.most;
  const std::string parts = Object()
                                .number("program", most.program)
                                .number("slices", most.texture)
                                .number("halo", most.halo)
                                .number("filter", most.filter)
                                .number("inputs", most.inputs)
                                .number("threads", most.threads)
                                .number("at_start", most.at_start)
                                .number("at_move", most.at_move)
                                .number("at_score", most.at_score)
                                .number("at_save", most.at_save)
                                .str();
  return Object()
      .number("rank_bytes", most.peak())
      .number("node_bytes", plan.node_bytes)
      .count("ranks_per_node", plan.request.ranks_per_node > 0 ? plan.request.ranks_per_node : plan.request.ranks)
      .raw("parts", parts)
      .raw("ranks", list(plan.ranks,
                         [](const PlanRank& rank) {
                           return Object()
                               .count("rank", rank.rank.value())
                               .count("slices", rank.slices)
                               .count("halo_slices", rank.halo_slices)
                               .number("bytes", rank.bytes)
                               .str();
                         }))
      .str();
}

std::string time(const RunPlan& plan) {
  const PlanTime& time = plan.time;
  Object object;
  object.text("stop", time.stop).number("seconds", time.total());
  object.number("seconds_low", time.total() / time.spread).number("seconds_high", time.total() * time.spread);
  object.number("start", time.start).number("moves", time.moves).number("scores", time.scores);
  object.number("exchange", time.exchange).number("saves", time.saves);
  object.count("iterations", time.iterations).count("num_scores", time.num_scores);
  object.number("score_seconds", time.score_s);
  const bool picks = plan.method == "void-and-cluster" || plan.method == "construct";
  object.number(picks ? "microseconds_per_pick" : "microseconds_per_candidate", time.candidate_us);
  return object.str();
}

}  // namespace

std::string plan_json(const RunPlan& plan) {
  Object object;
  object.text("texture", plan.texture).count("pixels", plan.pixels).count("slices", plan.num_slices);
  object.count("channels", plan.channels).text("samples", plan.samples).text("method", plan.method);
  object.count("ranks", plan.request.ranks).count("threads", plan.request.threads);
  object.count("idle_ranks", plan.idle_ranks);
  object.raw("axes", effects(plan.axes)).raw("effects", effects(plan.effects));
  object.raw("footprint", footprint(plan));
  object.raw("features", list(plan.features, [](const PlanFeatures& moment) {
               return Object().count("count", moment.count).number("missed", moment.missed).str();
             }));
  object.count("colour_classes", plan.num_classes).count("tiles", plan.num_tiles);
  object.count("iterations_per_sweep", plan.iterations_per_sweep);
  object.raw("memory", memory(plan));
  object.raw("disk",
             Object().number("run_file_bytes", plan.run_file_bytes).number("bytes_at_a_save", plan.disk_bytes).str());
  object.raw("exchange", Object()
                             .number("slice_updates_per_sweep", plan.exchange.slice_updates)
                             .number("messages_per_sweep", plan.exchange.messages)
                             .number("bytes_per_sweep", plan.exchange.bytes)
                             .str());
  if (plan.method == "void-and-cluster") {
    object.raw("phases", Object()
                             .number("points", plan.phases.points)
                             .number("swaps", plan.phases.swaps)
                             .text("measured_on", plan.phases.measured_on)
                             .str());
  }
  object.raw("time", time(plan));
  return object.str() + "\n";
}

}  // namespace noiseloom
