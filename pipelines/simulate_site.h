#pragma once

namespace CLI {
class App;
}

namespace vildar {

/// Adds `simulate site`.
CLI::App* add_simulate_site(CLI::App& simulate, int& exit_code);

}  // namespace vildar
