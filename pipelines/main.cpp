#include <cstdio>
#include <exception>
#include <iostream>

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

// The first word names a subcommand, where it is no option.
void check_subcommand(const CLI::App& program, int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return;
  std::string names;
  for (const CLI::App* command : program.get_subcommands([](const CLI::App*) { return true; })) {
    if (command->get_name() == argv[1]) return;
    names += (names.empty() ? "" : ", ") + command->get_name();
  }
  throw CLI::ExtrasError(
      "\"" + std::string(argv[1]) + "\" is no subcommand of this version, which has " + names,
      CLI::ExitCodes::ExtrasError);
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
  } catch (const std::exception& error) {
    return failed(kInternalError, error);
  }
  return exit_code;
}
