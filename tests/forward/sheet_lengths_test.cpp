#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "forward/data/scene_distribution.h"
#include "forward/sheet/scene.h"
#include "forward/sheet/sensor_json.h"
#include "tests/forward/disc_sheet.h"

namespace ertbench {
namespace {

using nlohmann::json;

const testing::DiscSheet disc_sheet;  ///< of which a domain unit is 50 mm

json scene(const char* text, const Sheet& sheet) {
  return to_json(scene_from_json(JsonObject(json::parse(text), "x.json", ""), sheet));
}

json distribution(const char* text, const Sheet& sheet) {
  return to_json(scene_distribution_from_json(JsonObject(json::parse(text), "x.json", ""), sheet));
}

template <typename Read>
std::string refusal_of(Read read) {
  try {
    read();
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

TEST(SheetLengths, ASceneInMillimetresIsThatInDomainUnits) {
  const char* const millimetres = R"({"contacts": [
      {"shape": "disc", "centre_mm": [10, -20], "radius_mm": 12, "conductivity_ratio": 0.5},
      {"shape": "ellipse", "centre_mm": [0, 5], "semi_axes_mm": [10, 8], "conductivity_ratio": 0.5},
      {"shape": "rectangle", "centre": [0.5, 0], "half_sides_mm": [10, 4], "angle": 1,
       "conductivity_ratio": 0.5},
      {"shape": "polygon", "vertices_mm": [[0, 0], [30, 0], [0, 20]], "conductivity_ratio": 2}]})";
  EXPECT_EQ(scene(millimetres, *square_sheet()), scene(R"({"contacts": [
      {"shape": "disc", "centre": [0.1, -0.2], "radius": 0.12, "conductivity_ratio": 0.5},
      {"shape": "ellipse", "centre": [0, 0.05], "semi_axes": [0.1, 0.08], "conductivity_ratio": 0.5},
      {"shape": "rectangle", "centre": [0.5, 0], "half_sides": [0.1, 0.04], "angle": 1,
       "conductivity_ratio": 0.5},
      {"shape": "polygon", "vertices": [[0, 0], [0.3, 0], [0, 0.2]], "conductivity_ratio": 2}]})",
                                                       *square_sheet()));
  // A smaller sheet: the same contact is a larger part of it.
  const json contacts = scene(millimetres, disc_sheet).at("contacts");
  EXPECT_EQ(contacts[0].at("radius"), 0.24);
  EXPECT_EQ(contacts[0].at("centre"), json({0.2, -0.4}));
  EXPECT_EQ(contacts[2].at("centre"), json({0.5, 0.0}));
}

TEST(SheetLengths, ADistributionInMillimetresIsThatInDomainUnits) {
  EXPECT_EQ(distribution(R"({"contacts": 2, "radius_mm": [5, 20], "gap_mm": 10})", *square_sheet()),
            distribution(R"({"contacts": 2, "radius": [0.05, 0.2], "gap": 0.1})", *square_sheet()));
  EXPECT_EQ(
      distribution(R"({"radius_mm": 20, "centre": {"x_mm": [-30, 100], "y": 0}})", *square_sheet()),
      distribution(R"({"radius": 0.2, "centre": {"x": [-0.3, 1], "y": 0}})", *square_sheet()));
  EXPECT_EQ(distribution(R"({"radius_mm": 20})", disc_sheet).at("radius"), json({0.4, 0.4}));
  // The largest that fits, and not a hair less.
  EXPECT_EQ(distribution(R"({"radius_mm": 50})", disc_sheet).at("radius"), json({1.0, 1.0}));
}

/// The middle of this one is not the origin of the domain units.
class ShiftedSheet : public testing::DiscSheet {
 public:
  ShiftedSheet() : DiscSheet({Eigen::Vector2d(2, 4), Eigen::Vector2d(4, 6)}) {}
};

TEST(SheetLengths, MillimetresCountFromTheMiddleOfTheSheet) {
  const ShiftedSheet sheet;
  const json contacts = scene(R"({"contacts": [
      {"shape": "disc", "centre_mm": [50, -25], "radius_mm": 10, "conductivity_ratio": 0.5},
      {"shape": "polygon", "vertices_mm": [[0, 0], [50, 0], [0, 50]], "conductivity_ratio": 2}]})",
                              sheet)
                            .at("contacts");
  EXPECT_EQ(contacts[0].at("centre"), json({4.0, 4.5}));
  EXPECT_EQ(contacts[1].at("vertices"), json::parse("[[3.0, 5.0], [4.0, 5.0], [3.0, 6.0]]"));
  const json centre =
      distribution(R"({"centre": {"x_mm": [-50, 50], "y_mm": 0}})", sheet).at("centre");
  EXPECT_EQ(centre.at("x"), json({2.0, 4.0}));
  EXPECT_EQ(centre.at("y"), json({5.0, 5.0}));
}

TEST(SheetLengths, RefusesBothFormsAtOnce) {
  EXPECT_EQ(
      refusal_of([] {
        scene(R"({"contacts": [{"shape": "disc", "centre": [0, 0], "radius": 0.1,
                                      "radius_mm": 10, "conductivity_ratio": 0.5}]})",
              *square_sheet());
      }),
      "x.json: /contacts/0/radius_mm: stands beside \"radius\", which says the same in domain "
      "units; remove one of the two");
  for (const char* text :
       {R"({"radius": 0.1, "radius_mm": 10})", R"({"contacts": 2, "gap": 0.1, "gap_mm": 10})",
        R"({"centre": {"x": 0, "x_mm": 0, "y": 0}})"}) {
    EXPECT_NE(refusal_of([&] { distribution(text, *square_sheet()); }).find("_mm: stands beside"),
              std::string::npos)
        << text;
  }
}

TEST(SheetLengths, MessagesSpeakOfTheFormThatStandsThere) {
  const auto refusal = [](const char* text, const Sheet& sheet) {
    return refusal_of([&] { distribution(text, sheet); });
  };
  EXPECT_EQ(refusal(R"({"radius_mm": 0})", *square_sheet()),
            "x.json: /radius_mm: must be from 0.0001 to 200 mm, got 0");
  EXPECT_EQ(refusal(R"({"radius_mm": 60})", disc_sheet),
            "x.json: /radius_mm: must be <= 50 mm for contacts placed \"inside\" the sheet");
  EXPECT_EQ(refusal(R"({"radius": 1.2})", disc_sheet),
            "x.json: /radius: must be <= 1 for contacts placed \"inside\" the sheet");
  EXPECT_EQ(refusal(R"({"contacts": 2, "radius": 0.4, "gap_mm": 50})", *square_sheet()),
            "x.json: /gap_mm: must leave room for both contacts: gap + 4 radius <= 200 mm");
  EXPECT_EQ(refusal(R"({"centre": {"x_mm": 101, "y": 0}})", *square_sheet()),
            "x.json: /centre/x_mm: must be from -100 to 100 mm, got 101");
  EXPECT_EQ(refusal(R"({"radius_cm": 6})", disc_sheet),
            "x.json: /radius_cm: unknown key; did you mean \"radius_mm\"?");
}

}  // namespace
}  // namespace ertbench
