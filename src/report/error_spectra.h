// The part of a rendering's page that shows where the errors of an effect lie, over the picture and over time.
#pragma once

#include <cstddef>

#include "noiseloom/render/result.h"
#include "report/report_writer.h"

namespace noiseloom {

// Needs the spectra of the result.
void add_error_spectra(const render::Result& result, std::size_t effect, ReportWriter& writer);

}  // namespace noiseloom
