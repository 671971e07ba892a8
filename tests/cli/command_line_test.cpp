#include "cli/command_line.hpp"

#include <gtest/gtest.h>

namespace carillon::cli {
namespace {

using testing::Test;

/// A program of two commands, one with an option of each kind.
class CommandLine : public Test {
 protected:
  CommandLine() {
    program.common().flag("--quiet", quiet, "no progress lines");
    Command& mix = program.add("mix", "of everything", Needs::ranks);
    mix.option("inputs", inputs, "files").required();
    mix.option("--count", count, "of them").range(1, 10).show_default();
    mix.option("--level", level, "[dB]").range(-60.0, 0.0);
    mix.option("--way", way, "there").one_of({"left", "right"}).show_default();
    mix.option("--name", name, "of it").show_default("none");
    mix.option("--set", overrides, "key=value").one_value_each();
    Option sizes = mix.option("-s,--sizes", ranks, "1,2,4");
    sizes.delimiter(',').range(1, 100).one_value_each();
    mix.option("--per-node", per_node, "ranks").needs(sizes);
    mix.option("--bytes", bytes, "of it");
    mix.option("--word", word, "not xyzzy").check([](const std::string& text) {
      return std::string(text == "xyzzy" ? "nothing happens" : "");
    });
    mix.footer("Example:\n  mix a");
    mix.does([this] { ++runs; });
    program.add("rest", "of nothing", Needs::nothing);
  }

  std::optional<Reply> parse(std::vector<const char*> words) {
    words.insert(words.begin(), "program");
    return program.parse(static_cast<int>(words.size()), words.data());
  }
  std::string refusal(const std::vector<const char*>& words) {
    const auto reply = parse(words);
    return reply && reply->refused ? reply->text : "";
  }
  std::string help() { return parse({"mix", "--help"}).value_or(Reply{}).text; }

  bool quiet = false;
  std::vector<std::string> inputs, overrides;
  int count = 3, per_node = 0;
  std::size_t bytes = 0;
  double level = 0;
  std::string way = "left", word;
  std::optional<std::string> name;
  std::vector<int> ranks;
  int runs = 0, versions = 0;
  Program program{"program", "Of a test.", [this] {
                    ++versions;
                    return std::string("program 1\nlibrary 2");
                  }};
};

TEST_F(CommandLine, ValuesReachTheirVariables) {
  EXPECT_FALSE(parse({"mix", "a", "b", "--count", "7", "--level", "-3.5", "--way", "right",
                      "--name", "x", "-s", "1,2,4", "--per-node", "2", "--quiet"}));
  EXPECT_EQ(inputs, (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(count, 7);
  EXPECT_EQ(level, -3.5);
  EXPECT_EQ(way, "right");
  EXPECT_EQ(name, "x");
  EXPECT_EQ(ranks, (std::vector<int>{1, 2, 4}));
  EXPECT_EQ(per_node, 2);
  EXPECT_TRUE(quiet);
}

TEST_F(CommandLine, VariablesKeepTheirDefaults) {
  EXPECT_FALSE(parse({"mix", "a"}));
  EXPECT_EQ(count, 3);
  EXPECT_EQ(way, "left");
  EXPECT_FALSE(name.has_value());
}

TEST_F(CommandLine, ParsingRunsNothing) {
  EXPECT_FALSE(parse({"mix", "a"}));
  EXPECT_EQ(runs, 0);
  EXPECT_EQ(program.chosen().name(), "mix");
  EXPECT_EQ(program.chosen().needs(), Needs::ranks);
  program.chosen().begin();
  EXPECT_EQ(runs, 0);
  program.chosen().run();
  EXPECT_EQ(runs, 1);
}

TEST_F(CommandLine, AnOptionWithOneValueLeavesTheNextToOthers) {
  EXPECT_FALSE(parse({"mix", "--set", "k=v", "a"}));
  EXPECT_EQ(overrides, std::vector<std::string>{"k=v"});
  EXPECT_EQ(inputs, std::vector<std::string>{"a"});
}

TEST_F(CommandLine, ValuesOutsideARangeAreRefused) {
  EXPECT_NE(refusal({"mix", "a", "--count", "11"}).find("not in range"), std::string::npos);
  EXPECT_NE(refusal({"mix", "a", "--level", "0.1"}).find("--level"), std::string::npos);
  EXPECT_NE(refusal({"mix", "a", "-s", "1,0"}).find("--sizes"), std::string::npos);
}

TEST_F(CommandLine, WordsOfNoSetAreRefused) {
  EXPECT_NE(refusal({"mix", "a", "--way", "up"}).find("\"up\" is none of left, right"),
            std::string::npos);
}

TEST_F(CommandLine, ChecksSayWhatIsWrong) {
  EXPECT_NE(refusal({"mix", "a", "--word", "xyzzy"}).find("nothing happens"), std::string::npos);
}

TEST_F(CommandLine, AnOptionNeedsTheOther) {
  EXPECT_NE(refusal({"mix", "a", "--per-node", "2"}).find("--sizes"), std::string::npos);
}

TEST_F(CommandLine, WhatIsRequiredMustBeThere) {
  EXPECT_NE(refusal({"mix"}).find("inputs is required"), std::string::npos);
  EXPECT_NE(refusal({}).find("a command is missing"), std::string::npos);
}

TEST_F(CommandLine, SlipsAreAnsweredWithWhatIsNearest) {
  EXPECT_EQ(refusal({"mxi", "a"}), "\"mxi\" is no command; did you mean \"mix\"?");
  EXPECT_EQ(refusal({"mix", "a", "--cuont=3"}),
            "--cuont: program mix has no such option; did you mean \"--count\"?");
  EXPECT_EQ(refusal({"mix", "a", "--quite"}),
            "--quite: program mix has no such option; did you mean \"--quiet\"?");
  EXPECT_EQ(refusal({"rest", "b"}), "\"b\": one word more than program rest takes");
  EXPECT_EQ(parse({"mix", "--cuont", "3"})->hint, "program mix --help says what it takes");
}

TEST_F(CommandLine, HelpOfACommandThatThereIsNotIsRefused) {
  EXPECT_EQ(refusal({"mxi", "--help"}), "\"mxi\" is no command; did you mean \"mix\"?");
  EXPECT_EQ(refusal({"--help"}), "");
}

TEST_F(CommandLine, ValuesThatAreMissingTwiceOrNoNumbersAreSaid) {
  EXPECT_EQ(refusal({"mix", "a", "--name"}), "--name: its value is missing");
  EXPECT_EQ(refusal({"mix", "a", "--name", "b", "--name", "c"}),
            "--name is given 2 times; once is enough");
  EXPECT_EQ(refusal({"mix", "a", "--bytes", "many"}),
            "--bytes: a whole number from 0 on is wanted, not \"many\"");
  EXPECT_NE(refusal({"mix", "a", "--bytes", "-1"}).find("a whole number from 0 on"),
            std::string::npos);
}

TEST_F(CommandLine, AnOptionThatIsThereCanBeChangedAndRemoved) {
  Command& other = program.add("other", "command", Needs::solver);
  other.option("inputs", inputs, "files").required();
  other.option("--count", count, "of them");
  other.option_named("inputs").required(false).description("none");
  other.remove("--count");
  EXPECT_FALSE(other.has("--count"));
  ASSERT_EQ(other.options().size(), 2u);  // with --help
  EXPECT_EQ(other.options()[1].description, "none");
  EXPECT_FALSE(parse({"other"}));
}

TEST_F(CommandLine, HelpShowsDefaultsRangesAndSets) {
  const std::string text = help();
  for (const char* part : {"INT:INT in [1 - 10]=3", "TEXT:{left,right}=left", "TEXT=none",
                           "FLOAT:FLOAT in [-60 - 0]", "-s,--sizes", "Example:\n  mix a"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << " in\n" << text;
  }
}

TEST_F(CommandLine, HelpAndVersionAreNotRefusals) {
  const auto reply = parse({"--version"});
  ASSERT_TRUE(reply);
  EXPECT_FALSE(reply->refused);
  EXPECT_EQ(reply->text, "program 1\nlibrary 2\n");
}

TEST_F(CommandLine, TheVersionIsMadeWhenItIsAskedFor) {
  EXPECT_FALSE(parse({"mix", "a"}));
  EXPECT_EQ(versions, 0);
}

TEST_F(CommandLine, MessagesSpeakOfOptions) {
  const Command& mix = program.commands().front();
  EXPECT_EQ(mix.in_options("say count: 3, or level: -6 dB; quiet: true"),
            "say --count 3, or --level -6dB; quiet: true");
  EXPECT_EQ(mix.in_options("raise per_node (name: mm)"), "raise --per-node (--name mm)");
  EXPECT_EQ(mix.in_options("no other way: left is left"), "no other way: left is left");
  EXPECT_EQ(program.common().in_options("or quiet: true helps"), "or --quiet helps");
  EXPECT_EQ(mix.in_options("count: three is no number"), "count: three is no number");
  EXPECT_EQ(mix.in_options("the count is 3"), "the count is 3");
}

TEST_F(CommandLine, OptionsCanBeListed) {
  const Command& mix = program.commands().front();
  EXPECT_EQ(mix.summary(), "of everything");
  EXPECT_EQ(mix.footer(), "Example:\n  mix a");
  for (const OptionText& option : mix.options()) {
    if (option.names == std::vector<std::string>{"inputs"}) {
      EXPECT_TRUE(option.positional);
    } else if (option.names == std::vector<std::string>{"--way"}) {
      EXPECT_EQ(option.choices, (std::vector<std::string>{"left", "right"}));
      EXPECT_TRUE(option.takes_value);
    } else if (option.names == std::vector<std::string>{"-s", "--sizes"}) {
      EXPECT_EQ(option.description, "1,2,4");
    }
  }
  EXPECT_EQ(program.common().options().back().names, std::vector<std::string>{"--quiet"});
}

}  // namespace
}  // namespace carillon::cli
