// The linear solvers against images that EIDORS made, from its own voltages. 1e-8: EIDORS solves
// the normal equations, whose condition, 1e3 to 1e4, amplifies rounding.

#include <gtest/gtest.h>

#include "tests/solvers/solver_testing.h"

namespace ertbench {
namespace {

using namespace testing;
using nlohmann::json;

struct Case {
  const char* dataset;
  json spec;
};

class EidorsImages : public ::testing::TestWithParam<Case> {};

TEST_P(EidorsImages, AreTheSame) {
  const Hdf5File file = eidors();
  const std::string name = std::string("/images/") + GetParam().dataset;
  const Images expected = file.read_rows(name, 0, 6);
  const Images images = reconstruct(*fitted(GetParam().spec), eidors_changes()).images;
  for (Eigen::Index f = 0; f < 6; ++f) {
    EXPECT_LT(relative_difference(images.row(f), expected.row(f)), 1e-8) << "scene " << f;
  }
}

json gn(const char* prior, const char* dataset) {
  return {{"type", "one-step-gn"},
          {"prior", prior},
          {"lambda", eidors().read_number(std::string("/images/") + dataset, "hyperparameter")}};
}

INSTANTIATE_TEST_SUITE_P(
    All, EidorsImages,
    ::testing::Values(
        Case{"gn_tikhonov", gn("tikhonov", "gn_tikhonov")},
        Case{"gn_noser", gn("noser", "gn_noser")}, Case{"gn_laplace", gn("laplace", "gn_laplace")},
        // EIDORS gives the threshold in percent.
        Case{"tsvd",
             {{"type", "tsvd"},
              {"threshold", eidors().read_number("/images/tsvd", "hyperparameter") / 100}}}),
    [](const auto& instance) { return instance.param.dataset; });

}  // namespace
}  // namespace ertbench
