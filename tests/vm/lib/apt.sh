# For: Debian packages of any suite and architecture, unpacked into a folder: no root, nothing installed, the
# system's apt untouched. Must not know: what the packages are for.
# Uses: $cache. Sets: nothing.

keyring=/usr/share/keyrings/debian-archive-keyring.gpg

# The mirror that this system uses itself.
apt_mirror() {
    local dir=/etc/apt
    { cat $dir/sources.list $dir/sources.list.d/*.sources $dir/sources.list.d/*.list 2>/dev/null || true; } |
        grep -v '^ *#' | grep -oE 'https?://[^ ]+/debian/?( |$)' | head -1 | tr -d ' ' || true
}

# apt_new NAME "ARCH..." SUITE...: an apt of its own below $cache/apt/NAME. Of the system's settings only those of
# transport (proxies) hold: its hooks would touch the system.
apt_new() {
    local dir=$cache/apt/$1 archs=$2 suite mirror
    shift 2
    mirror=$(apt_mirror)
    mkdir -p "$dir"/{lists/partial,cache/archives/partial}
    : >"$dir/status"
    for suite in "$@"; do echo "deb [signed-by=$keyring] $mirror $suite main"; done >"$dir/sources"
    cat >"$dir/conf" <<-CONF
	Dir::State::Lists "$dir/lists"; Dir::State::status "$dir/status"; Dir::Cache "$dir/cache";
	Dir::Etc::SourceList "$dir/sources"; Dir::Etc::SourceParts "/dev/null";
	Dir::Etc::Preferences "/dev/null"; Dir::Etc::PreferencesParts "/dev/null";
	APT::Architecture "${archs%% *}"; APT::Architectures { $(printf '"%s"; ' $archs) };
	Dir::Etc::Main "/dev/null"; Dir::Etc::Parts "/dev/null"; $(apt-config dump | grep -E '^Acquire::(https?|Check)' || true)
	APT::Install-Recommends "false"; APT::Sandbox::User "root"; Acquire::Languages "none"; Acquire::Retries "3";
	CONF
    APT_CONFIG=$dir/conf apt-get -qq -o APT::Update::Error-Mode=any update
}

# apt_kernel NAME SUITE[-rt]: the version that the suite's kernel for virtual machines, or its PREEMPT_RT one, has now.
apt_kernel() {
    local suite=${2%-rt} flavour=cloud
    [ "$suite" = "$2" ] || flavour=rt
    APT_CONFIG=$cache/apt/$1/conf apt-cache depends "linux-image-$flavour-arm64/$suite" |
        sed -n 's/.*Depends: linux-image-\([0-9][^ :]*\).*/\1/p' | head -1
}

# apt_tree NAME TREE PACKAGE...: exactly these packages, unpacked into $cache/tree/TREE.
apt_tree() {
    local conf=$cache/apt/$1/conf tree=$2
    shift 2
    tree_is "$tree" "$*" && return
    rm -rf "${cache:?}/deb/$tree"
    mkdir -p "$cache/deb/$tree"
    (cd "$cache/deb/$tree" && APT_CONFIG=$conf apt-get -qq download "$@")
    tree_unpack "$tree" "$*"
}

# apt_closure NAME TREE OPTION_OR_PACKAGE...: the same with everything that they depend on.
apt_closure() {
    local conf=$cache/apt/$1/conf tree=$2
    shift 2
    tree_is "$tree" "$*" && return
    rm -rf "${cache:?}/deb/$tree"
    mkdir -p "$cache/deb/$tree/partial"
    APT_CONFIG=$conf apt-get -qq -y -o "Dir::Cache::archives=$cache/deb/$tree" install --download-only "$@" >/dev/null
    tree_unpack "$tree" "$*"
}

# A tree is kept until it is asked for with other packages, or --refresh.
tree_is() { [ "$(cat "$cache/tree/$1.packages" 2>/dev/null)" = "$2" ]; }

# Beside the tree, in TREE.status: what is in it, as a dpkg would know that has installed it.
tree_unpack() {
    local deb
    rm -rf "${cache:?}/tree/$1"
    mkdir -p "$cache/tree/$1"
    for deb in "$cache/deb/$1"/*.deb; do
        dpkg -x "$deb" "$cache/tree/$1"
        dpkg -f "$deb" | sed '/^Package: /a Status: install ok installed' && echo
    done >"$cache/tree/$1.status"
    rm -rf "${cache:?}/deb/$1"
    echo "$2" >"$cache/tree/$1.packages"
}
