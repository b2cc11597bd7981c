#include "report/wipe.h"

#include <fmt/format.h>

#include "noiseloom/core/error.h"
#include "noiseloom/report/plot.h"

namespace noiseloom {
namespace {

std::string choices(const std::string& name, const char* side, std::size_t chosen,
                    const std::vector<std::pair<std::string, std::string>>& pictures) {
  std::string html = fmt::format("<div class='choices'><span>{}</span>", side);
  for (std::size_t i = 0; i < pictures.size(); ++i)
    html += fmt::format("<label><input type='radio' name='{0}-{1}' class='{1}{2}'{3}> {4}</label>", name, side, i,
                        i == chosen ? " checked" : "", xml_escaped(pictures[i].first));
  return html + "</div>\n";
}

}  // namespace

std::string wipe_html(const std::string& name, int width, int height,
                      const std::vector<std::pair<std::string, std::string>>& pictures) {
  NOISELOOM_CHECK(pictures.size() >= 2);
  // Each picture is in the page once: as a property of the figure that both sides refer to.
  std::string style = fmt::format("#{} {{", name);
  for (std::size_t i = 0; i < pictures.size(); ++i) style += fmt::format(" --p{}: url({});", i, pictures[i].second);
  style += " }\n";
  for (std::size_t i = 0; i < pictures.size(); ++i)
    style += fmt::format(
        "#{0}:has(.left{1}:checked) {{ --left: var(--p{1}); }} "
        "#{0}:has(.right{1}:checked) {{ --right: var(--p{1}); }}\n",
        name, i);
  return fmt::format(
      "<style>{}</style>\n<div class='wipe' id='{}'>\n{}{}"
      "<div class='right-picture' style='width:{}px;height:{}px'><div class='left-picture'></div></div></div>",
      style, name, choices(name, "left", 0, pictures), choices(name, "right", pictures.size() - 1, pictures), width,
      height);
}

}  // namespace noiseloom
