#include "datasets/number_table.h"

#include <gmock/gmock.h>

#include "common/error.h"

namespace hymm::core {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

NumberTable lines(const std::string& text) {
  return parseNumberTable(text, 2, RowEnd::kLine, "FILE");
}

template <class Call>
void expectRefusal(Call call, const std::string& part) {
  EXPECT_THAT(call, ThrowsMessage<InputError>(HasSubstr(part)));
}

TEST(NumberTable, ReadsTabsBlanksCommentsAndBothLineEnds) {
  const NumberTable table = lines("# head 1 2\n1\t 2.5\r\n\n% more\n -3e2 +4 \n");
  EXPECT_THAT(table.values, ElementsAre(1.0, 2.5, -300.0, 4.0));
  EXPECT_EQ(table.rows(), 2u);
  EXPECT_EQ(table.at(1, 0), -300.0);
}

TEST(NumberTable, RowsMayShareOneLine) {
  const NumberTable table = parseNumberTable("1\t2\t3\t4\t5\t6\t", 3, RowEnd::kLastNumber, "FILE");
  EXPECT_EQ(table.rows(), 2u);
  EXPECT_EQ(table.at(1, 2), 6.0);
}

TEST(NumberTable, NamesLineAndCharacterOfWhatIsNotANumber) {
  expectRefusal([] { lines("1 2\n3 4x5\n"); },
                "FILE, line 2, character 3: '4x5' is not a number (row 2, column 2)");
  expectRefusal([] { lines("1,2\n"); }, "line 1, character 1: '1,2'");
}

TEST(NumberTable, NamesPlaceWithinSingleLine) {
  expectRefusal([] { parseNumberTable("1\t2\t3\tfour", 2, RowEnd::kLastNumber, "FILE"); },
                "line 1, character 7: 'four' is not a number (row 2, column 2)");
}

TEST(NumberTable, RefusesLineOfAnotherLength) {
  expectRefusal([] { lines("1 2\n3\n4 5\n"); }, "line 2: has 1 numbers instead of 2");
  expectRefusal([] { lines("1 2\n3 4 5"); }, "line 2: has 3 numbers instead of 2");
}

TEST(NumberTable, RefusesIncompleteLastRow) {
  expectRefusal([] { parseNumberTable("1\t2\t3", 2, RowEnd::kLastNumber, "FILE"); },
                "ends within row 2, after column 1 of 2");
}

TEST(NumberTable, EmptyTextHasNoRows) { EXPECT_EQ(lines("").rows(), 0u); }

TEST(TryParseNumber, TakesWholeWordsOnly) {
  EXPECT_EQ(tryParseNumber("-1.5e-3"), -0.0015);
  EXPECT_EQ(tryParseNumber("1.5m"), std::nullopt);
  EXPECT_EQ(tryParseNumber(""), std::nullopt);
}

}  // namespace
}  // namespace hymm::core
