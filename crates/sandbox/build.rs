//! Gives the program its icon and its manifest where a program has them: on Windows.

fn main() {
    println!("cargo::rerun-if-changed=packaging");
    if std::env::var_os("CARGO_CFG_WINDOWS").is_some() {
        let mut resource = winresource::WindowsResource::new();
        resource.set_icon("packaging/inertia.ico");
        resource.set_manifest_file("packaging/windows.manifest");
        resource.set("ProductName", "Inertia").set("FileDescription", "Inertia, a physics sandbox");
        resource.compile().expect("windres or rc.exe is installed with the compiler for Windows");
    }
}
