#pragma once

#include <complex>
#include <vector>

#include "forward/sheet/border_piece.h"
#include "forward/sheet/scene.h"
#include "forward/sheet/sheet.h"

namespace ertbench {

/// A stretch of a contact's border along which the conductivity jumps from one value to another.
struct ContactArc {
  BorderPiece piece;
  double begin = 0;
  double end = 0;
  bool closed = false;  ///< a whole ellipse; else both ends are corners or junctions
  bool begins_at_sheet =
      false;  ///< the end lies on the sheet's border, where its mirror image joins
  bool ends_at_sheet = false;
  double left = 1;        ///< conductivity / background on the left of the direction of travel
  double right = 1;       ///< and on the right
  double grading = 3;     ///< of the points on it, see graded_parameter
  int contact = 0;        ///< whose border it is
  int left_contact = -1;  ///< which contact's conductivity `left` is, -1 the background
  int right_contact = -1;
};

/// The contacts that cover a point: the one whose ratio counts there, -1 where there is none.
int contact_at(const Scene& scene, std::complex<double> point);
double ratio_at(const Scene& scene, std::complex<double> point);

/// All stretches of border within the sheet at which the conductivity jumps: borders hidden in a
/// contact of lower ratio are left out, what several contacts share is there once. Exact up to
/// rounding for every scene, whatever overlaps or sticks out.
std::vector<ContactArc> contact_arcs(const Scene& scene, const Sheet& sheet);

/// Whether conductivities of this ratio differ so much, more than tenfold, that the equation takes
/// precautions which the usual contacts do without.
bool is_strong(double ratio);

/// Whether two arcs have an end in common.
bool are_joined(const ContactArc& a, const ContactArc& b);

}  // namespace ertbench
