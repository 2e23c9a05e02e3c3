// Which trainings used their budget of epochs up, and what the table says of them.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "bench/record/result_row.h"
#include "bench/report/result_table.h"
#include "bench/table/table.h"

namespace ertbench {
namespace {

using nlohmann::json;

ResultRow made_row(const std::string& label, json parameters) {
  ResultRow row;
  row.label = label;
  row.dataset = "test";
  row.parameters = std::move(parameters);
  return row;
}

json trained(int best_epoch) {
  return {{"epochs", 20}, {"training", {{"best_epoch", best_epoch}}}};
}

json cut_off() {
  return {{"epochs", 20}, {"training", {{"best_epoch", 20}, {"converged", false}}}};
}

ResultRow row_of_seeds() {
  ResultRow row = made_row("net", cut_off());
  row.seeds.emplace().values = {1, 2, 3};
  row.seeds->parameters = json::array({{{"training", cut_off().at("training")}},
                                       {{"training", {{"best_epoch", 19}}}},
                                       {{"training", cut_off().at("training")}}});
  return row;
}

std::string table_of(const std::vector<ResultRow>& rows) {
  return markdown_of(result_table(rows, TableText{}));
}

TEST(Convergence, IsReadFromWhatTheTrainingSaid) {
  EXPECT_EQ(convergence_of(made_row("gn", {{"lambda", 1}})).runs, 0);
  EXPECT_EQ(convergence_of(made_row("early", trained(12))).runs, 1);
  EXPECT_TRUE(convergence_of(made_row("early", trained(12))).all());
  EXPECT_FALSE(convergence_of(made_row("late", cut_off())).all());
  // A program from before trainings said so themselves.
  EXPECT_FALSE(convergence_of(made_row("older", trained(20))).all());
}

TEST(Convergence, IsCountedOverTheSeeds) {
  const Convergence convergence = convergence_of(row_of_seeds());
  EXPECT_EQ(convergence.runs, 3);
  EXPECT_EQ(convergence.not_converged, 2);
}

TEST(Convergence, TheFootOfTheTableNamesWhoHadNot) {
  const std::string foot = "had not converged: ";
  EXPECT_EQ(table_of({made_row("gn", {}), made_row("early", trained(12))}).find(foot),
            std::string::npos);
  ResultRow elsewhere = made_row("late", cut_off());
  elsewhere.dataset = "edge";  // the same network on another test set is named once
  const std::string text = table_of({made_row("early", trained(12)), made_row("late", cut_off()),
                                     elsewhere, made_row("older", trained(20)), row_of_seeds()});
  EXPECT_NE(text.find(foot + "late, older, net (2 of 3 seeds). "), std::string::npos) << text;
}

}  // namespace
}  // namespace ertbench
