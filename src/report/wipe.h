// Pictures laid over each other: one is chosen for the left part and one for the right, and the border between them is
// drawn with the mouse. Without scripts, by the style of the page.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace noiseloom {

// `pictures`: names and sources (embedded_source), at least two, all of that size in CSS pixels. `name`: a word that no
// other of the page has.
std::string wipe_html(const std::string& name, int width, int height,
                      const std::vector<std::pair<std::string, std::string>>& pictures);

}  // namespace noiseloom
