#include <cstdio>
#include <exception>
#include <iostream>
#include <new>
#include <string>

#include <CLI/CLI.hpp>

#include "core/error.h"
#include "pipelines/commands.h"
#include "pipelines/interrupt.h"
#include "pipelines/version.h"

namespace {

// Exit codes of the contract, section 4.
constexpr int kInternalError = 1;
constexpr int kUsage = 2;
constexpr int kInputUnreadable = 3;
constexpr int kOutputUnwritable = 5;
constexpr int kKilledBySignal = 128;  // plus its number, as shells report it

int failed(int code, const std::exception& error) {
  std::cerr << "vildar: " << error.what() << '\n';
  return code;
}

// With --json, standard output is the result: a full disk there must not look like success.
void check_standard_output() {
  std::cout.flush();
  if (!std::cout || std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
    throw vildar::OutputError("standard output cannot be written; look for space where it goes to");
}

// The first word names a subcommand, where it is no option, and so does the one after it where that
// asks for one itself.
void check_subcommand(const CLI::App& command, int argc, char** argv) {
  const auto below = command.get_subcommands([](const CLI::App*) { return true; });
  if (command.get_require_subcommand_min() == 0 || argc < 2 || argv[1][0] == '-') return;
  std::string names;
  for (const CLI::App* one : below) {
    if (one->get_name() == argv[1]) return check_subcommand(*one, argc - 1, argv + 1);
    names += (names.empty() ? "" : ", ") + one->get_name();
  }
  throw CLI::ExtrasError("\"" + std::string(argv[1]) + "\" is no subcommand of this version" +
                             (command.get_name() == "vildar" ? "" : " of " + command.get_name()) +
                             ", which has " + names,
                         CLI::ExitCodes::ExtrasError);
}

// No option and no file has an empty value: it is a script's variable that is not set.
void refuse_empty_values(CLI::App& command) {
  for (CLI::Option* option : command.get_options())
    if (option->get_expected_min() > 0)
      option->check(
          [](const std::string& value) {
            return value.empty() ? std::string("is empty; give it a value or leave it out")
                                 : std::string();
          },
          "");
  for (CLI::App* below : command.get_subcommands([](const CLI::App*) { return true; }))
    refuse_empty_values(*below);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App program{
      "Speed of vehicles at night from the light of their headlamps.\n"
      "Example: vildar run clip.mp4 --site site.yaml --out results"};
  program.name("vildar");
  program.set_version_flag("--version", std::string("vildar ") + vildar::kVersion);
  program.require_subcommand(1);

  int exit_code = 0;
  vildar::add_run(program, exit_code);
  vildar::add_render(program, exit_code);
  vildar::add_evaluate(program, exit_code);
  vildar::add_simulate(program, exit_code);
  vildar::add_calibrate(program, exit_code);
  refuse_empty_values(program);

  try {
    check_subcommand(program, argc, argv);
    program.parse(argc, argv);
    check_standard_output();
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return program.exit(error);
    std::cerr << "vildar: " << error.what()
              << "; see `vildar --help` and `vildar SUBCOMMAND --help`\n";
    return kUsage;
  } catch (const vildar::ConfigError& error) {
    return failed(kUsage, error);
  } catch (const vildar::InputError& error) {
    return failed(kInputUnreadable, error);
  } catch (const vildar::OutputError& error) {
    return failed(kOutputUnwritable, error);
  } catch (const vildar::Interrupted& interrupted) {
    return failed(kKilledBySignal + interrupted.signal(), interrupted);
  } catch (const std::bad_alloc&) {
    std::cerr
        << "vildar: not enough memory for this input; give it less at once, or a machine with "
           "more\n";
    return kInternalError;
  } catch (const std::exception& error) {
    return failed(kInternalError, error);
  }
  return exit_code;
}
