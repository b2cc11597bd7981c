// Which passes are on, what they are expected to do, and how that is told.
#include <fmt/format.h>

#include <algorithm>

#include "noiseloom/core/json.h"
#include "noiseloom/core/quantity_text.h"
#include "noiseloom/render/passes.h"
#include "noiseloom/render/result.h"
#include "render/jobs/frames.h"

namespace noiseloom::render {
namespace {

// Seconds of one processor for a unit of each kind of work, as measured on one of 2.1 GHz.
constexpr double seconds_of_work[num_work] = {4e-7,   2e-9,   2e-8,  2.5e-8, 2e-7,   4e-8, 1e-7,   6e-9,   4e-8,
                                              1.2e-9, 3.5e-8, 4e-10, 7e-9,   1.5e-9, 1e-8, 1.2e-7, 1.5e-7, 4e-8};

constexpr std::string_view data_names[num_data] = {
    "noises",      "picture",  "density",     "light",        "columns",    "flights",     "mesh",
    "mesh shares", "hits",     "moving hits", "edge weights", "kernel",     "importance",  "sky",
    "sky truths",  "carrying", "seeds",       "truth",        "estimate",   "accumulated", "filtered",
    "seen",        "errors",   "stacks",      "pictures",     "predictions"};
constexpr std::string_view work_names[num_work] = {
    "expectations", "texture_values", "computed_values",    "estimates",   "primary_rays",  "rays",
    "mesh_rays",    "march_steps",    "density_reads",      "averages",    "history_reads", "taps",
    "guided_taps",  "differences",    "transformed_values", "moved_seeds", "ranks",         "exchanges"};

std::int64_t calls_of(const Pass& pass, const Scene& scene, std::size_t num_noises) {
  if (pass.frame == nullptr) return 1;
  const std::int64_t jobs = static_cast<std::int64_t>(num_noises) * scene.repeats;
  // An effect has jobs of its own; whatever follows is called for all effects.
  const bool is_effect = pass.makes.has(Data::estimate);
  return jobs * num_rendered(scene) * (is_effect ? 1 : std::ssize(effects_of(scene)));
}

std::string count_text(double count) {
  if (count < 1e4) return fmt::format("{:.0f}", count);
  return count < 1e6 ? fmt::format("{:.1f} k", count / 1e3) : fmt::format("{:.4g} M", count / 1e6);
}

std::string work_text(const Counts& counts) {
  std::string text;
  for (int i = 0; i < num_work; ++i) {
    const std::int64_t count = counts[static_cast<std::size_t>(i)];
    if (count == 0) continue;
    std::string name(work_names[i]);
    std::replace(name.begin(), name.end(), '_', ' ');
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count_text(static_cast<double>(count)), name);
  }
  return text;
}

std::string counts_json(const Counts& counts) {
  std::string text = "{";
  for (int i = 0; i < num_work; ++i)
    text += fmt::format("{}\"{}\": {}", i == 0 ? "" : ", ", work_names[i], counts[static_cast<std::size_t>(i)]);
  return text + "}";
}

}  // namespace

std::string_view name_of(Data data) { return data_names[static_cast<std::size_t>(data)]; }
std::string_view name_of(Work work) { return work_names[static_cast<std::size_t>(work)]; }

std::vector<PlannedPass> plan_passes(std::span<const Pass> passes, const Scene& scene, std::span<const Noise> noises) {
  std::vector<PlannedPass> planned;
  for (const Pass& pass : passes)
    planned.push_back({.pass = &pass, .on = false, .why = "", .calls = 0, .work = {}, .bytes = 0});
  DataSet wanted = {Data::errors};
  if (scene.puts_out("spectra")) wanted.add({Data::stacks});
  if (scene.puts_out("predictions")) wanted.add({Data::predictions});
  if (scene.puts_out("images")) wanted.add({Data::pictures});
  for (auto one = planned.rbegin(); one != planned.rend(); ++one) {
    const Pass& pass = *one->pass;
    const std::string off = pass.off(scene);
    if (!off.empty()) {
      one->why = "off: " + off;
    } else if (!wanted.meets(pass.makes)) {
      one->why = "off: nothing needs what it makes";
    } else {
      one->on = true;
      wanted.add(pass.needs);
      one->calls = calls_of(pass, scene, noises.size());
      one->work = pass.work(scene, noises);
      one->bytes = pass.bytes(scene, noises);
    }
  }
  // Said forward: what is on serves whoever reads what it makes.
  for (PlannedPass& one : planned) {
    if (!one.on) continue;
    std::string readers;
    for (const PlannedPass& other : planned)
      if (other.on && other.pass->needs.meets(one.pass->makes))
        readers += (readers.empty() ? "" : ", ") + std::string(other.pass->name);
    one.why = readers.empty() ? "is put out" : "for " + readers;
  }
  return planned;
}

double predicted_seconds(const PlannedPass& planned) {
  double seconds = 0;
  for (std::size_t i = 0; i < planned.work.size(); ++i)
    seconds += static_cast<double>(planned.work[i]) * seconds_of_work[i];
  return seconds;
}

std::string plan_text(std::span<const PlannedPass> passes) {
  std::string text =
      fmt::format("{:<18} {:<4} {:>9} {:>10} {:>9}   {}\n", "pass", "", "calls", "memory", "seconds", "why and what");
  for (const PlannedPass& one : passes) {
    const std::string work = work_text(one.work);
    text += one.on
                ? fmt::format("{:<18} {:<4} {:>9} {:>10} {:>9}   {}{}\n", one.pass->name, "on", one.calls,
                              bytes_text(static_cast<double>(one.bytes)), fmt::format("{:.2f}", predicted_seconds(one)),
                              one.why, work.empty() ? "" : ": " + work)
                : fmt::format("{:<18} {:<4} {:>9} {:>10} {:>9}   {}\n", one.pass->name, "off", "-", "-", "-",
                              one.why.substr(one.why.find(' ') + 1));
  }
  return text;
}

std::string plan_json(const Scene& scene, const std::vector<PassResult>& passes, double seconds, int threads) {
  std::string text = fmt::format(
      "{{\n  \"title\": {}, \"width\": {}, \"height\": {}, \"frames\": {}, \"repeats\": {},\n  \"passes\": [",
      json_string(scene.title), scene.width, scene.height, scene.frames, scene.repeats);
  bool first = true;
  for (const PassResult& one : passes) {
    text += fmt::format(
        "{}\n    {{\"name\": {}, \"on\": {}, \"why\": {}, \"calls\": {{\"predicted\": {}, \"counted\": {}}}, "
        "\"bytes\": {}, \"seconds\": {{\"predicted\": {}, \"counted\": {}}},\n     \"predicted\": {},\n     "
        "\"counted\": {}}}",
        first ? "" : ",", json_string(std::string(one.planned.pass->name)), one.planned.on ? "true" : "false",
        json_string(one.planned.why), one.planned.calls, one.calls, one.planned.bytes,
        json_number(predicted_seconds(one.planned)), json_number(one.seconds), counts_json(one.planned.work),
        counts_json(one.counted));
    first = false;
  }
  return text + fmt::format("\n  ],\n  \"seconds\": {}, \"threads\": {}\n}}\n", json_number(seconds), threads);
}

}  // namespace noiseloom::render
