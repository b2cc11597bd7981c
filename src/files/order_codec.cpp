#include "noiseloom/files/order_codec.h"

#include <fmt/format.h>

#include <algorithm>

namespace noiseloom {

bool is_order_run(const RunFileContent& content) {
  return std::any_of(content.datasets.begin(), content.datasets.end(),
                     [](const SliceDataset& dataset) { return dataset.name == order_name; });
}

void require_finished_order(const RunFileContent& content, const std::string& path) {
  const auto finished = content.state.find("finished");
  if (!content.state.contains("phase") || finished == content.state.end() || finished->second != Attribute("")) return;
  const auto ranked = content.state.find("ranked");
  const bool counted = ranked != content.state.end() && std::holds_alternative<std::int64_t>(ranked->second);
  throw UserError(path, fmt::format("not finished: {} of {} pixels have their place in the order; go on with generate "
                                    "--resume",
                                    counted ? std::get<std::int64_t>(ranked->second) : 0, content.extents.num_cells()));
}

}  // namespace noiseloom
