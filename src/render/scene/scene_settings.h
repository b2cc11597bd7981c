// Parts of the table of settings of a scene.
#pragma once

#include <vector>

#include "noiseloom/config/settings.h"
#include "noiseloom/config/settings_reader.h"
#include "noiseloom/render/scene.h"

namespace noiseloom::render {

// The words that rows are written in.
using settings::above;
using settings::at_least;
using settings::Field;
using settings::Setting;
using settings::Type;
using settings::Word;

std::vector<Setting> rows_of_noises();
std::vector<Setting> rows_of_effects();
std::vector<Setting> rows_of_object();
std::vector<Setting> rows_of_more_effects();
std::vector<Setting> rows_of_filters();

// Gives noises and filters that have no name that of what they are, then holds against each other what settings name.
void check_scene(settings::Reader& reader, const settings::Value& root, const settings::Owners& owners);

}  // namespace noiseloom::render
