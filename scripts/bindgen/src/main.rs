//! Writes the JavaScript by which a page calls a module of WebAssembly: `bindgen MODULE FOLDER`.

use std::env::args;

use wasm_bindgen_cli_support::Bindgen;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let [_, module, folder] = &args().collect::<Vec<_>>()[..] else {
        return Err("usage: bindgen MODULE FOLDER".into());
    };
    Bindgen::new().web(true)?.typescript(false).input_path(module).out_name("page").generate(folder)?;
    Ok(())
}
