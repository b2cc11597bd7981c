// The sections of a report that show how a texture's power is spread over frequencies.
#pragma once

#include "noiseloom/measure/quality.h"
#include "noiseloom/problem/spec.h"
#include "report/report_writer.h"

namespace noiseloom {

// What all of them look at. `filter` may be null.
struct SpectrumSource {
  const Texture& texture;
  DistanceKind kind;
  const SpectralQuality& quality;
  const FilterSpec* filter;
};

// Adds a section for the frequencies of a slice, one for x with each slice axis longer than 1, one for every other
// group of axes of the filter, and one for the lowest frequencies of all of them.
void add_spectrum_sections(ReportWriter& writer, const SpectrumSource& source);

}  // namespace noiseloom
