# Installs the command `precomp` for one user on Windows, without a compiler.
#
#   PRECOMP_FROM   where the archives and SHA256SUMS lie: an address or a folder (default: the newest release)
#   PRECOMP_TO     folder for the command (default: %LOCALAPPDATA%\Programs\precomp)
$ErrorActionPreference = "Stop"
$from = if ($env:PRECOMP_FROM) { $env:PRECOMP_FROM } else { "https://github.com/precomp/precomp/releases/latest/download" }
$to = if ($env:PRECOMP_TO) { $env:PRECOMP_TO } else { Join-Path $env:LOCALAPPDATA "Programs\precomp" }
$target = "x86_64-pc-windows-msvc"
if ($env:PROCESSOR_ARCHITECTURE -ne "AMD64") { throw "there is no archive for $($env:PROCESSOR_ARCHITECTURE); build it with 'cargo install --path .'" }

$work = New-Item -ItemType Directory -Path (Join-Path ([IO.Path]::GetTempPath()) ([Guid]::NewGuid()))
try {
    function Fetch($name) {
        $file = Join-Path $work $name
        if ($from -match "^https?://") { Invoke-WebRequest -UseBasicParsing -Uri "$from/$name" -OutFile $file } else { Copy-Item (Join-Path $from $name) $file }
        return $file
    }
    $sums = Get-Content (Fetch "SHA256SUMS")
    $line = $sums | Where-Object { $_ -match "^([0-9a-f]{64}) [ *](precomp-.*-$target\.zip)$" } | Select-Object -Last 1
    if (-not $line) { throw "$from names no archive for $target" }
    $null = $line -match "^([0-9a-f]{64}) [ *](.*)$"
    $expected, $name = $Matches[1], $Matches[2]
    $archive = Fetch $name
    if ((Get-FileHash -Algorithm SHA256 $archive).Hash -ne $expected) { throw "the SHA-256 of $name is not the one stated" }
    Expand-Archive -Path $archive -DestinationPath $work
    New-Item -ItemType Directory -Force -Path $to | Out-Null
    Copy-Item -Force (Join-Path $work ([IO.Path]::GetFileNameWithoutExtension($name)) "precomp.exe") $to
    & (Join-Path $to "precomp.exe") --version
    Write-Output "installed in $to"
    $path = [Environment]::GetEnvironmentVariable("Path", "User")
    if (($path -split ";") -notcontains $to) {
        [Environment]::SetEnvironmentVariable("Path", "$path;$to", "User")
        Write-Output "added to the search path of new windows"
    }
} finally {
    Remove-Item -Recurse -Force $work
}
