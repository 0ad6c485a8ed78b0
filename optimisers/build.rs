//! Searches for IPOPT (Debian: `coinor-libipopt-dev`); if it is missing, the crate is built without it.

fn main() {
    println!("cargo::rustc-check-cfg=cfg(has_ipopt)");
    println!("cargo::rerun-if-env-changed=PKG_CONFIG_PATH");
    if let Ok(ipopt) = pkg_config::Config::new().cargo_metadata(false).probe("ipopt") {
        println!("cargo::rustc-cfg=has_ipopt");
        ipopt.link_paths.iter().for_each(|path| println!("cargo::rustc-link-search=native={}", path.display()));
        // IPOPT brings its own dependencies.
        println!("cargo::rustc-link-lib=ipopt");
    }
}
