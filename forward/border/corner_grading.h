#pragma once

#include <vector>

#include "forward/border/contact_arcs.h"

namespace ertbench {

/// Where a border ends, at a corner of its contact, at another border or at the sheet's, the
/// potential goes like r^lambda. With the exponent p of the grading (see graded_parameter) the
/// points' error falls as their number to the -p lambda: third order with the usual p = 3 as long
/// as lambda is about 1. Strong contacts have corners with lambda down to 1/2; their arcs get the p
/// that makes third order of it again.
void set_gradings(const Sheet& sheet, std::vector<ContactArc>& arcs);

/// The smallest positive lambda, at most 1, of two wedges side by side that fill a straight angle
/// on whose sides no current passes: conductivities `first` and `second`, and the first's angle.
double corner_exponent(double first, double second, double angle);

}  // namespace ertbench
