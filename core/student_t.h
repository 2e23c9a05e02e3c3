#pragma once

namespace ertbench {

/// The value that a variable with Student's t distribution is below with `probability`, between 0
/// and 1. Throws std::invalid_argument for other values, or where there is no degree of freedom.
double student_t_quantile(double probability, int degrees_of_freedom);

}  // namespace ertbench
