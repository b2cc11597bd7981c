// What one method asks of settings that others share: looked up before the tables are read, checked afterwards.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "config/config_read.h"

namespace noiseloom::settings {
namespace {

constexpr double max_sigma = 1000;  // check_vac_spec

const Value* find_below(const Value* value, std::string_view key) {
  const Table* table = value == nullptr ? nullptr : value->table();
  return table == nullptr ? nullptr : find(*table, key);
}

// True for a known word that is not `wanted`: one that is not known has been reported already.
bool is_other_word(const Value* value, const Setting& setting, std::string_view wanted) {
  const auto* text = value == nullptr ? nullptr : std::get_if<std::string>(&value->data);
  return text != nullptr && *text != wanted &&
         std::any_of(setting.words.begin(), setting.words.end(), [&](const Word& w) { return w.word == *text; });
}

}  // namespace

void ConfigReader::look_up_method(const Value& root) {
  const Value* method = find_below(find_below(&root, "optimizer"), "method");
  const Setting& setting = row("optimizer.method");
  if (method != nullptr && !set_word(setting, *method, {.config = &config_})) undecided_.push_back(setting.key);
}

void ConfigReader::check_void_and_cluster(const Value& root) {
  const std::string with = "with method = \"void-and-cluster\" ";
  const Value* samples = find_below(find_below(&root, "texture"), "samples");
  if (samples != nullptr &&
      (samples->table() != nullptr || is_other_word(samples, row("texture.samples"), "uniform"))) {
    fault(*samples, "texture.samples", with + "they must be \"uniform\": the order of the pixels makes the values");
  }
  const Value* filter = find_below(&root, "filter");
  const Value* combine = find_below(filter, "combine");
  const Value* groups = find_below(filter, "groups");
  const Array* list = groups == nullptr ? nullptr : groups->array();
  if (list == nullptr) return;
  const std::string sum = with + "several groups need combine = \"sum\"";
  if (list->size() > 1 && combine == nullptr) {
    fault(groups->place, "filter.combine: missing; " + sum);
  } else if (list->size() > 1 && is_other_word(combine, row("filter.combine"), "sum")) {
    fault(*combine, "filter.combine", sum);
  }
  for (std::size_t i = 0; i < list->size(); ++i) {
    const std::string shown = fmt::format("filter.groups[{}].", i);
    const GroupSpec& group = config_.problem.filter.groups[i];
    const Value* kernel = find_below(&(*list)[i], "kernel");
    if (is_other_word(kernel, row("filter.groups[].kernel"), "gauss-energy")) {
      fault(*kernel, shown + "kernel", with + "it must be \"gauss-energy\"");
    }
    const Value* sigma = find_below(&(*list)[i], "sigma");
    if (sigma != nullptr && group.kernel.kind == KernelKind::gauss_energy && group.kernel.sigma > max_sigma) {
      fault(*sigma, shown + "sigma", fmt::format("{}must be at most {}", with, max_sigma));
    }
    const Value* weight = find_below(&(*list)[i], "weight");
    const double share = 1.0 / static_cast<double>(list->size());
    if (weight != nullptr && group.weight > 0 && std::abs(group.weight - share) > 1e-6) {
      fault(*weight, shown + "weight", fmt::format("{}all groups weigh the same: leave the weights out", with));
    }
  }
}

}  // namespace noiseloom::settings
