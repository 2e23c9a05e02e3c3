#include "solvers/registry/registry.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "core/errors.h"
#include "forward/fem/forward_model.h"
#include "tests/solvers/solver_testing.h"

namespace ertbench {
namespace {

using namespace testing;
using nlohmann::json;

/// $ERTBENCH_PLUGINS for the length of a test.
class PluginFolders {
 public:
  explicit PluginFolders(const std::string& folders) {
    ::setenv("ERTBENCH_PLUGINS", folders.c_str(), 1);
  }
  ~PluginFolders() { ::unsetenv("ERTBENCH_PLUGINS"); }
};

std::string failure(SolverRegistry& registry, const json& spec) {
  return message_of<InputError>([&] { registry.make(JsonObject(spec, "a.json", "/solvers/2")); });
}

TEST(Registry, KnowsTheSolvers) {
  EXPECT_EQ(SolverRegistry().types(),
            (std::vector<std::string>{"one-step-gn", "tsvd", "lmmse", "pdipm", "gauss-newton",
                                      "contacts", "kernel-ridge", "command", "exported", "fcnn",
                                      "dcnn", "eit-nn", "dd-ert", "lean-net", "torchscript"}));
}

TEST(Registry, DescribesEveryParameterThatASolverReports) {
  SolverRegistry registry;
  for (const char* type : {"one-step-gn", "tsvd", "lmmse", "pdipm", "gauss-newton"}) {
    const SolverInfo* const info = registry.find(type);
    ASSERT_NE(info, nullptr);
    EXPECT_FALSE(info->summary.empty());
    const json reported = make_solver({{"type", type}})->parameters();
    for (const auto& [name, value] : reported.items()) {
      EXPECT_TRUE(std::any_of(info->parameters.begin(), info->parameters.end(),
                              [&](const ParameterInfo& p) { return p.name == name; }))
          << type << " " << name;
    }
  }
}

TEST(Registry, NamesTheKnownTypesBesideAnUnknownOne) {
  SolverRegistry registry;
  const std::string message = failure(registry, {{"type", "gauss"}});
  EXPECT_EQ(
      message.find("a.json: /solvers/2/type: no solver is called \"gauss\"; known: one-step-gn"),
      0u)
      << message;
  EXPECT_EQ(registry.find("gauss"), nullptr);
  EXPECT_EQ(failure(registry, {{"label", "x"}}), "a.json: /solvers/2/type: is missing");
}

TEST(Registry, TakesALabel) {
  SolverRegistry registry;
  EXPECT_EQ(failure(registry, {{"type", "tsvd"}, {"rank", 3}, {"label", "three"}}), "");
}

TEST(Registry, SaysWhereAMissingPluginWasLookedFor) {
  SolverRegistry registry;
  registry.add_plugin_type("elsewhere", "libelsewhere.so");
  const PluginFolders folders("/first:/second");
  const std::string message = failure(registry, {{"type", "elsewhere"}});
  EXPECT_EQ(message.find("a.json: /solvers/2/type: elsewhere lives in libelsewhere.so, which is "
                         "not in "),
            0u)
      << message;
  EXPECT_NE(message.find("/first, /second"), std::string::npos) << message;
  EXPECT_EQ(registry.find("elsewhere"), nullptr);
}

TEST(Registry, ReportsABrokenPlugin) {
  const TemporaryFolder folder;
  std::ofstream(folder / "libbroken.so") << "not a library";
  const PluginFolders folders((folder / "").string());
  SolverRegistry registry;
  registry.add_plugin_type("broken", "libbroken.so");
  registry.allow_plugins();
  const std::string message = failure(registry, {{"type", "broken"}});
  EXPECT_NE(message.find("cannot be loaded"), std::string::npos) << message;
  EXPECT_EQ(registry.find("broken"), nullptr);
  // The others are unharmed.
  EXPECT_EQ(failure(registry, {{"type", "tsvd"}, {"rank", 3}}), "");
}

TEST(Registry, LoadsAPluginWhenOneOfItsSolversIsMade) {
  const std::filesystem::path library = ERTBENCH_TEST_PLUGIN;
  const PluginFolders folders(library.parent_path().string());
  SolverRegistry registry;
  registry.add_plugin_type("back-projection", library.filename().string());
  EXPECT_THROW(failure(registry, {{"type", "back-projection"}}), std::logic_error);
  registry.allow_plugins();
  const json spec = {{"type", "back-projection"}, {"gain", 2}};
  const std::unique_ptr<Solver> solver = registry.make(JsonObject(spec, "", ""));
  solver->fit(FitInput{});
  EXPECT_EQ(solver->parameters(), (json{{"gain", 2}, {"inference_check", true}}));
  EXPECT_EQ(solver->fit_report().frame_check, "electrodes that read zero alone");
  const Frames changes = eidors_changes();
  const Images expected = 2 * changes * ForwardModel(Sensor{}, Sensor{}.image_grid).jacobian();
  EXPECT_LT(relative_difference(reconstruct(*solver, changes).images, expected), 1e-14);
  EXPECT_EQ(failure(registry, {{"type", "back-projection"}, {"gian", 2}})
                .find("a.json: /solvers/2/gian: unknown key"),
            0u);
}

TEST(Registry, AddsTheTypesOfALoadedPluginAndRefusesThemTwice) {
  SolverRegistry registry;
  registry.load_plugin(ERTBENCH_TEST_PLUGIN);
  EXPECT_EQ(registry.types().back(), "back-projection");
  EXPECT_NE(registry.find("back-projection"), nullptr);
  const std::string twice =
      message_of<InputError>([&] { registry.load_plugin(ERTBENCH_TEST_PLUGIN); });
  EXPECT_NE(twice.find("two solvers are called \"back-projection\""), std::string::npos) << twice;
}

TEST(Registry, GivesEverySolverTheSharedParameters) {
  SolverRegistry registry;
  registry.load_plugin(ERTBENCH_TEST_PLUGIN);
  for (const char* type : {"one-step-gn", "tsvd", "pdipm", "back-projection"}) {
    const ParameterInfo* const parameter = registry.find(type)->parameter("inference_check");
    ASSERT_NE(parameter, nullptr) << type;
    EXPECT_EQ(parameter->role, ParameterRole::inference);
  }
}

TEST(Registry, SaysWhatTheHarnessNeedsToKnow) {
  SolverRegistry registry;
  EXPECT_EQ(registry.find("one-step-gn")->comparison, ImageComparison::rounding);
  EXPECT_EQ(registry.find("tsvd")->comparison, ImageComparison::rounding);
  EXPECT_EQ(registry.find("pdipm")->comparison, ImageComparison::duality_gap);
  EXPECT_TRUE(registry.find("one-step-gn")->break_even_reference);
  EXPECT_FALSE(registry.find("tsvd")->break_even_reference);
  EXPECT_EQ(registry.find("tsvd")->parameter("inference_precision")->role,
            ParameterRole::inference);
  EXPECT_EQ(registry.find("tsvd")->parameter("rank")->role, ParameterRole::fit);
  EXPECT_FALSE(registry.find("tsvd")->has_seed());
}

TEST(Registry, RefusesARegistrationThatContradictsItself) {
  const auto complaint = [](std::vector<ParameterInfo> parameters, ImageComparison comparison) {
    SolverRegistry registry;
    return message_of<InputError>([&] {
      registry.add("odd", {"", std::move(parameters), nullptr, comparison});
    });
  };
  const ParameterInfo seed = {"seed", "", ParameterRole::seed};
  EXPECT_EQ(complaint({seed}, ImageComparison::seeds), "");
  EXPECT_EQ(complaint({seed}, ImageComparison::rounding).find("odd: images are to be compared"),
            0u);
  EXPECT_EQ(complaint({}, ImageComparison::seeds).find("odd: images are to be compared"), 0u);
  EXPECT_EQ(complaint({{"seed", ""}}, ImageComparison::rounding).find("odd: parameter \"seed\""),
            0u);
  EXPECT_EQ(complaint({{"inference_x", ""}}, ImageComparison::rounding)
                .find("odd: parameter \"inference_x\""),
            0u);
  EXPECT_EQ(complaint({{"speed", "", ParameterRole::inference}}, ImageComparison::rounding)
                .find("odd: parameter \"speed\""),
            0u);
}

TEST(Registry, RefusesALibraryThatIsNoPlugin) {
  SolverRegistry registry;
  const std::string message =
      message_of<InputError>([&] { registry.load_plugin(ERTBENCH_SOLVERS_LIBRARY); });
  EXPECT_NE(message.find("has no ertbench_solver_interface"), std::string::npos) << message;
}

/// Why the registry does not take a plugin.
std::string refusal_of(const char* library) {
  SolverRegistry registry;
  return message_of<InputError>([&] { registry.load_plugin(library); });
}

TEST(Registry, RefusesAPluginThatDoesNotSayWhatItWasBuiltWith) {
  const std::string message = refusal_of(ERTBENCH_SILENT_PLUGIN);
  EXPECT_NE(message.find("ERTBENCH_SOLVER_PLUGIN"), std::string::npos) << message;
}

// These two abort as soon as they are loaded: nothing of them may run.
TEST(Registry, RefusesAPluginOfAnotherAlignmentUnloaded) {
  const std::string message = refusal_of(ERTBENCH_OTHER_ALIGNMENT_PLUGIN);
  EXPECT_NE(message.find("Eigen's alignment 128 bytes"), std::string::npos) << message;
  EXPECT_NE(message.find("here " + std::to_string(EIGEN_MAX_ALIGN_BYTES) + " bytes"),
            std::string::npos)
      << message;
  EXPECT_EQ(message.find("compiler"), std::string::npos) << message;
}

TEST(Registry, RefusesAPluginOfAnotherInstructionSetUnloaded) {
#ifndef __AVX__
  GTEST_SKIP() << "this build has no AVX that a plugin could lack";
#endif
  const std::string message = refusal_of(ERTBENCH_NO_AVX_PLUGIN);
  EXPECT_NE(message.find("instruction set sse2 sse4.2, here sse2 sse4.2 avx"), std::string::npos)
      << message;
  EXPECT_EQ(message.find("compiler"), std::string::npos) << message;
}

TEST(Registry, NamesWhatAPluginDiffersIn) {
  EXPECT_EQ(abi_difference(program_abi()), "");
  std::string other = program_abi();
  const std::string version = std::to_string(EIGEN_WORLD_VERSION) + "." +
                              std::to_string(EIGEN_MAJOR_VERSION) + "." +
                              std::to_string(EIGEN_MINOR_VERSION);
  other.replace(other.find("Eigen=" + version), 6 + version.size(), "Eigen=3.3.9");
  EXPECT_EQ(abi_difference(other), "Eigen 3.3.9, here " + version);
  EXPECT_EQ(abi_difference("").find("C++ library that it does not say"), 0u);
}

TEST(Registry, RefusesAPluginOfAnotherInterface) {
  SolverRegistry registry;
  const std::string message =
      message_of<InputError>([&] { registry.load_plugin(ERTBENCH_OUTDATED_PLUGIN); });
  EXPECT_NE(message.find("solver interface"), std::string::npos) << message;
}

}  // namespace
}  // namespace ertbench
