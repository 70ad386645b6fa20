#pragma once

namespace CLI {
class App;
}

namespace vildar {

/// Each adds one subcommand to the program; its callback stores the exit code of the contract, or
/// throws ConfigError, InputError or OutputError, which main() turns into message and code.
void add_run(CLI::App& program, int& exit_code);
void add_render(CLI::App& program, int& exit_code);
void add_evaluate(CLI::App& program, int& exit_code);
void add_simulate(CLI::App& program, int& exit_code);
void add_calibrate(CLI::App& program, int& exit_code);

/// Subcommands of `calibrate`.
void add_calibrate_mount(CLI::App& calibrate, int& exit_code);
void add_calibrate_psf(CLI::App& calibrate, int& exit_code);
void add_calibrate_photodiode(CLI::App& calibrate, int& exit_code);

}  // namespace vildar
