// Changes of a tree before it is read: former keys, and --set KEY=VALUE.
#pragma once

#include <string>
#include <vector>

#include "noiseloom/config/settings.h"
#include "noiseloom/config/tree.h"

namespace noiseloom::settings {

// Gives what stands under a former key its present one. Where the table has that too, both stay as they are.
void rename_former_keys(const FileKind& kind, Value& root);

// Applies "texture.seed=2" or "filter.groups[0].size=3". An index one past the end appends. What is wrong with the
// override itself is added to `faults`; what is wrong with the value, or with a key that the kind of file does not
// have, is found when the tree is read.
void apply_override(const FileKind& kind, Value& root, const std::string& override_text, std::vector<Fault>& faults);

}  // namespace noiseloom::settings
