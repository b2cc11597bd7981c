// Numbers as people read them.
#pragma once

#include <string>

namespace noiseloom {

std::string duration_text(double seconds);  // "7.2 s", "3 min 5 s", "2 h 14 min"
std::string bytes_text(double bytes);       // "3.5 MiB"
// Three digits that count, from 1e-9 up without an exponent, so that numbers beside each other compare at a glance:
// "0.000432", "1.02", "1230".
std::string digits_text(double value);
// "1.20 M picks/s", "3.4 k picks/s"
std::string rate_text(double per_second, const char* what);

}  // namespace noiseloom
